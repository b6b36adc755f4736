"""Frames of a client that a container which replaces this one gets again, and what such a one posts to the clone.

A frame is settled once what it caused is in a stored checkpoint, was answered, or may be lost. A subscription or an
advertisement stands until it is withdrawn.
"""

from collections import deque
from collections.abc import Callable, Container
from typing import Literal

from engine.protocols.session_frames import NumberedFrame
from engine.sessions.place.place import Place
from ppaas.errors import Unavailable
from ppaas.wire.operations import Id

Key = tuple[str | int | None, ...]
"""What a standing operation is about: the operation, its name, and the id by which it is withdrawn."""


class _Claim:
    """Frames that are executed as one, and the number of reasons for which they are not settled."""

    __slots__ = ("numbers", "reasons")

    def __init__(self, number: int) -> None:
        self.numbers = [number]
        self.reasons = 1  # its execution


class UnsettledFrames:
    """Frames of one client that are not settled.

    Parameters
    ----------
    report : callable
        Called when there are settled frames that were not reported yet.
    """

    def __init__(self, report: Callable[[], None] = lambda: None) -> None:
        self._report = report
        self._frames: dict[int, NumberedFrame] = {}
        self._parts: dict[Id, list[int]] = {}
        self._claim = _Claim(0)
        self._named = 0
        self._settled: list[int] = []
        self._sequences: deque[tuple[int, _Claim]] = deque()
        self._standing: dict[Key, _Claim] = {}

    def frames(self) -> list[NumberedFrame]:
        """Return the frames that are not settled, in order."""
        return [self._frames[number] for number in sorted(self._frames)]

    def take_settled(self) -> list[int]:
        """Return the frames that were settled since the last call."""
        settled, self._settled = self._settled, []
        return settled

    # -- the frame that is executed ------------------------------------------------------------------------------------

    def begin(self, frame: NumberedFrame) -> None:
        """Begin the execution of a frame."""
        self._frames[frame.number] = frame
        self._named = 0
        self._claim = _Claim(frame.number)

    def gather(self, incomplete: Container[Id]) -> None:
        """Join the fragments to the frame that completed or dropped theirs: all but those of incomplete frames."""
        for identity in [identity for identity in self._parts if identity not in incomplete]:
            self._claim.numbers += self._parts.pop(identity)

    def wait_for_rest(self, identity: Id) -> None:
        """Note that the frame is a fragment of an incomplete one, which is executed with its last fragment."""
        self._parts.setdefault(identity, []).append(self._claim.numbers[0])

    def end(self) -> None:
        """End the execution of a frame; it is settled now, unless there is a reason against it."""
        self._release(self._claim)

    def answer(self, send: Callable[[Callable[[], None]], None]) -> None:
        """Answer the frame, which is settled with the last of its answers.

        Parameters
        ----------
        send : callable
            Sends the answer; called with a function that must be called when the answer is sent.
        """
        send(self.until_released())

    def until_released(self) -> Callable[[], None]:
        """Leave the frame unsettled until the function that is returned is called."""
        claims = [self._claim]
        self._claim.reasons += 1

        def release() -> None:
            while claims:
                self._release(claims.pop())

        return release

    def until_acknowledged(self, sequence: int) -> None:
        """Leave the frame unsettled until a checkpoint contains the message that it sent; 0 if it may be lost."""
        if sequence:
            self._claim.reasons += 1
            self._sequences.append((sequence, self._claim))

    def until_withdrawn(self, key: Key) -> None:
        """Leave the frame unsettled until what it set up is withdrawn, or set up again."""
        self._claim.reasons += 1
        before, self._standing[key] = self._standing.get(key), self._claim
        if before is not None:
            self._release(before)

    def next_name(self) -> str:
        """Return a name that no other operation has, and that the same operation has when its frame is repeated."""
        self._named += 1
        return f"{self._claim.numbers[0]}-{self._named}"

    # -- settling ------------------------------------------------------------------------------------------------------

    def acknowledged(self, sequence: int) -> None:
        """Settle the frames whose messages are in a checkpoint."""
        while self._sequences and self._sequences[0][0] <= sequence:
            self._release(self._sequences.popleft()[1])

    def withdrawn(self, *key: str | int | None) -> None:
        """Settle the frames of what is withdrawn: all keys that begin with this one."""
        for known in [known for known in self._standing if known[: len(key)] == key]:
            self._release(self._standing.pop(known))

    def _release(self, claim: _Claim) -> None:
        claim.reasons -= 1
        if claim.reasons:
            return
        for number in claim.numbers:
            if self._frames.pop(number, None) is not None:
                self._settled.append(number)
        if self._settled:
            self._report()


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
