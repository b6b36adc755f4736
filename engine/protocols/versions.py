"""Versions of the protocol between the processes of a cloud: each process states a range of them in its handshakes.

One number counts for all links. It grows with each release that changes a message. A release also speaks the version of
the release before, so that the processes of a cloud are upgraded one after another. Both ends use the highest version
that they have in common; without one, the peer is refused.
"""

import msgspec

from ppaas import __version__
from ppaas.errors import Conflict

SHOWN = 64
"""Number of characters of the release of a peer in an error."""


class Protocols(msgspec.Struct, frozen=True):
    """Range of the protocol versions that a process speaks, from the oldest to the newest."""

    oldest: int
    newest: int

    def __str__(self) -> str:
        return f"protocol {self.newest}" if self.oldest == self.newest else f"protocols {self.oldest} to {self.newest}"


OWN = Protocols(1, 2)
"""Range of this release. A change of a message needs a new version: tests/unit/engine/protocols/test_wire_schema.py."""

UNSTATED = Protocols(1, 1)
"""Range of builds of release 0.2.0 whose handshakes state none."""

_UNSTATED_BY = "0.2.0"
_UNKNOWN = Protocols(0, 0)


def stated_by(release: str, stated: Protocols | None) -> Protocols:
    """Return the range of a peer, as its handshake states it, or as its release is known to speak."""
    if stated is not None:
        return stated
    return UNSTATED if release == _UNSTATED_BY else _UNKNOWN


def agree(peer: str, release: str, stated: Protocols | None, own: Protocols = OWN) -> int:
    """Return the protocol version of a link: the highest that this process and its peer have in common.

    Parameters
    ----------
    peer : str
        Description of the peer, for the error.
    release : str
        Release of the peer; empty if it is not known.
    stated : Protocols, optional
        Range in the handshake of the peer; None if the handshake has none.
    own : Protocols
        Range of this process.

    Raises
    ------
    Conflict
        They have none in common; the text has both ranges, and what to upgrade first.
    """
    theirs = stated_by(release, stated)
    highest = min(own.newest, theirs.newest)
    if highest >= max(own.oldest, theirs.oldest):
        return highest
    behind = "this process" if own.newest < theirs.newest else peer
    least = max(own.oldest, theirs.oldest)
    raise Conflict(
        f"{peer} runs release {release[:SHOWN] or '(unknown)'} with {_in_words(theirs)}, and this process runs "
        f"{__version__} with {own}: upgrade {behind} first, to a release that speaks protocol {least}"
    )


def _in_words(protocols: Protocols) -> str:
    return "unknown protocols" if protocols == _UNKNOWN else str(protocols)
