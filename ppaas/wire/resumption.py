"""How a client finds its session again on another connection: what it says in the address, and what it is told in the
headers of the handshake. Nothing of it is a frame, so that clients of plain rosbridge are not disturbed.

Both sides count the frames of a session that they took from the other. Whoever knows the count of the other side knows
which of its own frames were lost with the connection, and sends those, and no others, again.
"""

import re
from dataclasses import dataclass

from ppaas.errors import InvalidParameter

SESSION = "session"
RESUME = "resume"
ANEW = "none"
"""What ``resume`` says where the client knows of no session: one that is there is not its own, and is ended."""

NEW = "new"
RESUMED = "resumed"
"""What the first of the headers says."""

STATE_HEADER = "PPaaS-Session"
ID_HEADER = "PPaaS-Session-Id"
TAKEN_HEADER = "PPaaS-Session-Taken"

LEFT = "left"
"""Reason in the close frame (1000) of a client that does not come back: its session need not be kept."""

_NAME = re.compile(r"[A-Za-z0-9._~-]{1,64}")
_POINT = re.compile(r"(?P<id>[A-Za-z0-9_-]{1,64})\.(?P<received>[0-9]{1,15})")


@dataclass(frozen=True, slots=True)
class ResumptionPoint:
    """How far a client got.

    Parameters
    ----------
    id : str
        Of the session, as the cloud told it.
    received : int
        Frames that the client took in it.
    """

    id: str
    received: int

    def __str__(self) -> str:
        """Return it as ``resume`` carries it."""
        return f"{self.id}.{self.received}"


def parse_name(text: str) -> str:
    """Return the name that a client gave its session.

    Raises
    ------
    InvalidParameter
        Not such a name.
    """
    if not _NAME.fullmatch(text):
        raise InvalidParameter("a session's name has 1 to 64 letters, digits and . _ ~ -")
    return text


def parse_point(text: str) -> ResumptionPoint | None:
    """Return how far a client got, or None if it begins anew.

    Raises
    ------
    InvalidParameter
        Not what ``resume`` may say.
    """
    if text == ANEW:
        return None
    match = _POINT.fullmatch(text)
    if match is None:
        raise InvalidParameter(f"'resume' is {ANEW!r}, or the id of a session, a dot and a count of frames")
    return ResumptionPoint(match["id"], int(match["received"]))
