"""Node ``recorder``: hands the messages of a clone to the recorder of its machine, for recordings and a ring."""

from collections.abc import Callable
from datetime import UTC, datetime
from typing import ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import Conflict, InvalidParameter
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.health.recorder import (
    GetRecorderState,
    RecorderState,
    StartRecording,
    StartRecordingRequest,
    StopRecording,
)
from ppaas.nodes.base import Context, Node, Reply, Service
from ppaas.nodes.message_checks import expect
from ppaas.nodes.recorder.intake import Bus, Intake
from ppaas.recording.batches import About, Batch, Entry, batch_bytes
from ppaas.recording.parameters import NAME, RecorderParameters, checked_globs

PERIOD = 0.5
"""Period at which messages are handed over [s]: if the clone is killed, those since are lost."""

MOST_SECONDS = 3600.0
"""Longest recording [s]."""

MOST_PENDING = 4 << 20
"""Size of the messages that wait at most, beyond which they are handed over at once [bytes]."""

Sink = Callable[[bytes], bool]
"""Called with a batch; returns whether the machine takes it."""


class Recording(msgspec.Struct, frozen=True):
    """A recording in progress: its id, its end [s since the epoch] and the globs of its topics."""

    id: str
    until: float
    globs: tuple[str, ...]


class RecorderNode(Node):
    """Collects messages while a ring or a recording is wanted; it hears nothing otherwise.

    Parameters
    ----------
    context : Context
        The node's context.
    bus : Bus
        Topics of the executor; messages are heard after the nodes that use them.
    parameters : RecorderParameters
    about : callable
        Returns robot, parameters and current map, which each batch names.
    sink : callable
        Takes the batches.
    """

    name: ClassVar[str] = NAME
    services: ClassVar[tuple[Service, ...]] = (
        Service("recorder/start", StartRecording),
        Service("recorder/stop", StopRecording),
        Service("recorder/state", GetRecorderState),
    )

    def __init__(
        self, context: Context, bus: Bus, parameters: RecorderParameters, about: Callable[[], About], sink: Sink
    ) -> None:
        super().__init__(context)
        self._parameters, self._about, self._sink = parameters, about, sink
        self._ring_globs = checked_globs(parameters.topics) if parameters.ring_minutes else ()
        self._intake = Intake(bus, context.now, self._take)
        self._entries: list[Entry] = []
        self._pending = self._messages = self._lost = 0
        self._recording: Recording | None = None
        self._handed = ""
        self._problem = ""

    def start(self) -> None:
        """Begin with the ring, if the robot file has one."""
        self._intake.hear(self._ring_globs)
        self.context.every(PERIOD, self._tick)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Start or stop a recording; the answer is the state of the recorder.

        Raises
        ------
        Conflict
            A recording is in progress.
        InvalidParameter
            The time or the topics are invalid.
        """
        if service == "recorder/start":
            self._begin(expect(request, StartRecordingRequest))
        elif service == "recorder/stop":
            self._end()
        else:
            expect(request, Empty)
        reply(self.state())

    def state(self) -> RecorderState:
        """Return the state of the recorder."""
        recording = self._recording
        return RecorderState(
            recording="" if recording is None else recording.id,
            left=0.0 if recording is None else max(recording.until - self.context.now(), 0.0),
            ring_minutes=self._parameters.ring_minutes,
            messages=self._messages,
            lost=self._lost + self._intake.too_large,
            problem=self._problem,
        )

    def told(self, problem: str, *, forgotten: bool = False, lost: int = 0) -> None:
        """Note an answer of the recorder of the machine.

        Parameters
        ----------
        problem : str
            Why it does not record, which ends a recording; empty if it does.
        forgotten : bool
            Whether it has forgotten the last messages of latched topics, because it was started again.
        lost : int
            Number of batches that were dropped, because it is too slow.
        """
        self._problem, self._lost = problem, self._lost + lost
        if problem and self._recording is not None:
            self._end()
        if forgotten:
            self._intake.repeat()

    # -- recordings ----------------------------------------------------------------------------------------------------

    def _begin(self, request: StartRecordingRequest) -> None:
        if self._recording is not None:
            raise Conflict(f"recording {self._recording.id} is in progress: stop it first")
        if not 0.0 < request.seconds <= MOST_SECONDS:
            raise InvalidParameter(f"a recording takes more than 0 s and at most {MOST_SECONDS:g} s")
        globs = checked_globs(tuple(request.topics) or self._parameters.topics)
        now = self.context.now()
        self._problem = ""
        self._hand_over()  # what was heard before is of the ring alone
        self._recording = Recording(f"{datetime.fromtimestamp(now, UTC):%Y%m%dT%H%M%SZ}", now + request.seconds, globs)
        self._intake.hear(self._globs())
        self._intake.repeat()
        self._hand_over()

    def _end(self) -> None:
        self._hand_over()
        self._recording = None
        self._intake.hear(self._globs())
        self._hand_over()

    def _globs(self) -> tuple[str, ...]:
        return self._ring_globs + (() if self._recording is None else self._recording.globs)

    def _tick(self) -> None:
        globs = self._globs()
        if not globs:
            return
        if self._recording is not None and self.context.now() >= self._recording.until:
            self._end()
            return
        self._intake.hear(globs)
        self._intake.sample(self.context.elapsed())
        self._hand_over()

    # -- messages ------------------------------------------------------------------------------------------------------

    def _take(self, entry: Entry) -> None:
        self._entries.append(entry)
        self._pending += len(entry.payload)
        if self._pending > MOST_PENDING:
            self._hand_over()

    def _hand_over(self) -> None:
        """Hand over the messages so far; the end of a recording is handed over even without messages."""
        recording = "" if self._recording is None else self._recording.id
        entries, self._entries, self._pending = self._entries, [], 0
        if not entries and recording == self._handed:
            return
        if self._sink(batch_bytes(self._batch(recording, entries))):
            self._messages += len(entries)
            self._handed = recording
        else:
            self._lost += len(entries)

    def _batch(self, recording: str, entries: list[Entry]) -> Batch:
        ring, now = self._parameters, self._recording
        return Batch(
            about=self._about(),
            ring_seconds=ring.ring_seconds,
            ring_bytes=ring.max_mb * 1_000_000,
            ring_topics=self._ring_globs,
            recording=recording,
            recording_topics=() if now is None else now.globs,
            entries=entries,
        )

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes | None:
        """Return the recording in progress, which the container that replaces this one continues."""
        return None if self._recording is None else msgspec.json.encode(self._recording)

    def restore(self, state: bytes) -> None:
        """Continue a recording."""
        self._recording = from_json(state, Recording)
        self._intake.hear(self._globs())
