"""Peers that have connected and not shown yet who they are: bounded, so that silent ones make room for others."""

import logging
from typing import Protocol

from engine.processes.occasional_log import OccasionalLog

logger = logging.getLogger(__name__)

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
