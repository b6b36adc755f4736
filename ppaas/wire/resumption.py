"""Resumption of a session on another connection, by query parameters and handshake headers.

The client names its session in the address, and the server answers in the headers of the handshake. No frames are
added, so plain rosbridge clients are not affected.

Each side counts the frames that it received in the session. From the count of the other side, a side knows which of its
own frames were lost with the connection, and sends only those again.
"""

import re
from dataclasses import dataclass

from ppaas.errors import InvalidParameter

SESSION = "session"
RESUME = "resume"
ANEW = "none"
"""Value of ``resume`` for a client without a session; an existing session of that name is ended."""

NEW = "new"
RESUMED = "resumed"
"""Values of `STATE_HEADER`."""

STATE_HEADER = "PPaaS-Session"
ID_HEADER = "PPaaS-Session-Id"
TAKEN_HEADER = "PPaaS-Session-Taken"
ENDPOINT_HEADER = "PPaaS-Endpoint"
"""Address of an endpoint on the machine of the robot's container, for the next connection."""

LEFT = "left"
"""Reason in the close frame (1000) of a client that will not come back, so its session need not be retained."""

_NAME = re.compile(r"[A-Za-z0-9._~-]{1,64}")
_POINT = re.compile(r"(?P<id>[A-Za-z0-9_-]{1,64})\.(?P<received>[0-9]{1,15})")


@dataclass(frozen=True, slots=True)
class ResumptionPoint:
    """Point at which a client resumes its session.

    Parameters
    ----------
    id : str
        Id of the session, from `ID_HEADER`.
    received : int
        Number of frames that the client received in the session.
    """

    id: str
    received: int

    def __str__(self) -> str:
        """Return the value of ``resume``."""
        return f"{self.id}.{self.received}"


def parse_name(text: str) -> str:
    """Validate and return the name that a client gave its session.

    Raises
    ------
    InvalidParameter
        It is not a valid name.
    """
    if not _NAME.fullmatch(text):
        raise InvalidParameter("the name of a session must have 1 to 64 letters, digits, or characters of . _ ~ -")
    return text


def parse_point(text: str) -> ResumptionPoint | None:
    """Return the point at which a client resumes its session, or None if it starts a new one.

    Raises
    ------
    InvalidParameter
        It is not a valid value of ``resume``.
    """
    if text == ANEW:
        return None
    match = _POINT.fullmatch(text)
    if match is None:
        raise InvalidParameter(
            f"'resume' must be {ANEW!r}, or 'id.count': a session's id and the number of frames received"
        )
    return ResumptionPoint(match["id"], int(match["received"]))
