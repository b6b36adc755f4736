"""Handshakes of incoming connections: those that are expected, and peers that have not shown yet who they are.

An expected connection has a name and a secret, and comes once. Unproven peers are bounded, so that silent ones make
room for others.
"""

import hmac
import logging
from typing import Generic, Protocol, TypeVar

from engine.processes.occasional_log import OccasionalLog
from ppaas.errors import NotPermitted

logger = logging.getLogger(__name__)

T = TypeVar("T")


def is_same(secret: str, given: str) -> bool:
    """Compare secrets in constant time."""
    return hmac.compare_digest(secret.encode(), given.encode())


class PendingHandshakes(Generic[T]):
    """The expected connections, each with data for its handler."""

    def __init__(self) -> None:
        self._pending: dict[str, tuple[str, T]] = {}

    def __len__(self) -> int:
        """Return the number of expected connections."""
        return len(self._pending)

    def expect(self, name: str, secret: str, known: T) -> None:
        """Expect one connection with this name and secret."""
        self._pending[name] = (secret, known)

    def forget(self, name: str) -> None:
        """Stop expecting a connection."""
        self._pending.pop(name, None)

    def check(self, name: str, given: str) -> T:
        """Return the data of an expected connection, which is still expected; raises as ``admit`` does."""
        if name not in self._pending or not is_same(self._pending[name][0], given):
            raise NotPermitted(f"{name[:64]!r} is not expected here, or has the wrong secret")
        return self._pending[name][1]

    def admit(self, name: str, given: str) -> T:
        """Accept a connection; return the data that was passed to ``expect``.

        After a wrong secret the connection is still expected, so a stranger cannot take its place.

        Raises
        ------
        NotPermitted
            The name is not expected, or the secret is wrong.
        """
        known = self.check(name, given)
        self.forget(name)
        return known


def place_secret(secret: str, place: str, generation: int) -> str:
    """Return the secret for a container of a place.

    Parameters
    ----------
    secret : str
        Secret of the endpoint, which the endpoint and the master know.
    place : str
        Name of the place.
    generation : int
        Number of the container among the place's containers.
    """
    return hmac.digest(secret.encode(), f"{generation} {place}".encode(), "sha256").hex()


MOST = 512
"""Largest number of such peers of one listener. Genuine ones say who they are with their first bytes."""


class Stream(Protocol):
    """Connection of a peer."""

    def abort(self) -> None:
        """Abort the connection without waiting for the peer."""
        ...


class UnprovenPeers:
    """Connections of one listener whose peers have shown no secret and no registration yet.

    Parameters
    ----------
    listener : str
        Name of the listener in the log.
    """

    def __init__(self, listener: str) -> None:
        self._listener = listener
        self._streams: dict[Stream, None] = {}
        self._log = OccasionalLog(logger)

    def __len__(self) -> int:
        """Return the number of such peers."""
        return len(self._streams)

    def came(self, stream: Stream) -> None:
        """Add a new peer; the one that has been silent for longest makes room if there are too many."""
        if len(self._streams) >= MOST:
            oldest = next(iter(self._streams))
            del self._streams[oldest]
            oldest.abort()
            self._log.warning(
                "%s: %d peers have connected and say nothing; the oldest make room for others", self._listener, MOST
            )
        self._streams[stream] = None

    def proved(self, stream: Stream) -> None:
        """Remove a peer that has shown who it is, or has left."""
        self._streams.pop(stream, None)
