"""Posting: messages of one client on their way to the clone, also those that an earlier container got already."""

from collections.abc import Callable
from typing import Literal

from engine.sessions.place.place import Place
from engine.sessions.unsettled import UnsettledFrames
from ppaas.errors import Unavailable

Replay = Literal["", "sent", "applied"]
"""Origin of the frame that is executed: new, sent to an earlier container, or executed there before the checkpoint that
this container began with."""


class Posting:
    """Publishes messages of a client.

    Parameters
    ----------
    place : Place
        Place of the robot.
    client : int
        Number of the client at the place.
    unsettled : UnsettledFrames
        Frames of the client.
    count_plan : callable
        Called for each path request of the client; raises if the rate is exceeded.

    Attributes
    ----------
    replay : {"", "sent", "applied"}
        Origin of the frame that is executed now.
    """

    def __init__(self, place: Place, client: int, unsettled: UnsettledFrames, count_plan: Callable[[], None]) -> None:
        self.unsettled = unsettled
        self.replay: Replay = ""
        self._place = place
        self._client = client
        self._count_plan = count_plan

    def post(self, topic: str, payload: bytes, *, must_arrive: bool, latch: bool = False) -> int:
        """Publish a message, unless the clone has it already; return its sequence number, 0 if it has none.

        Raises
        ------
        NotFound
            There is no such topic.
        QuotaExceeded
            Too many messages are not acknowledged, or the latched messages are too large.
        """
        if self.replay == "applied" or (self.replay and not must_arrive):
            return 0
        sequence = self._place.publish(topic, payload, self._client, must_arrive=must_arrive, latch=latch)
        self.unsettled.until_acknowledged(sequence)
        return sequence

    def count_plan(self) -> None:
        """Count a path request, once; raises if the rate is exceeded."""
        if not self.replay:
            self._count_plan()

    def check_new(self) -> None:
        """Raise ``Unavailable`` if an earlier container got the frame: it may have done what cannot be repeated."""
        if self.replay:
            raise Unavailable("the container was lost before it answered; call again")
