"""Link that a clone serves: to an endpoint, or to the sessions of the clone's clients."""

from engine.links.frame_writer import FrameWriter
from engine.protocols import robot_link

FarEnd = FrameWriter[robot_link.FromContainer]
"""The other end of a link."""


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
