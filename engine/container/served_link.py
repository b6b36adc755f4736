"""Link that a clone serves: to an endpoint, or to the sessions of the clone's clients."""

from typing import Protocol

from engine.protocols import robot_link


class FarEnd(Protocol):
    """The other end of a link."""

    def write(self, frame: robot_link.FromContainer) -> None:
        """Queue a frame; it is lost while nobody is connected."""
        ...

    @property
    def waiting(self) -> int:
        """Number of written bytes that are still queued."""
        ...


class ServedLink:
    """A link with its subscriptions.

    Parameters
    ----------
    end : FarEnd
        Its other end.
    applied : int
        Sequence number of the last message of this link that the clone has processed.

    Attributes
    ----------
    wanted : set of str
        Topics that it is subscribed to.
    """

    def __init__(self, end: FarEnd, applied: int = 0) -> None:
        self.end = end
        self.applied = applied
        self.wanted: set[str] = set()
