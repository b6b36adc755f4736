"""Node ``recorder``: hands the messages of a clone to the recorder of its machine, for recordings and a ring."""

from collections.abc import Callable, Collection
from datetime import UTC, datetime
from typing import ClassVar, Protocol

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import Conflict, InvalidParameter
from ppaas.messages import encode, type_name
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.health.watching import (
    GetRecorderState,
    RecorderState,
    StartRecording,
    StartRecordingRequest,
    StopRecording,
)
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.message_checks import expect
from ppaas.recording.batches import About, Batch, BatchedMessage, batch_bytes
from ppaas.recording.parameters import NAME, RecorderParameters, checked_globs, selects

# -- intake of the recorder --------------------------------------------------------------------------------------------

GOALS = {
    topics.SIMPLE_GOAL.name: topics.MOVE_BASE_RESULT.name,
    topics.GOAL_POSE.name: topics.MOVE_BASE_RESULT.name,
    topics.MOVE_BASE_GOAL.name: topics.MOVE_BASE_RESULT.name,
    topics.WAYPOINTS_GOAL.name: topics.WAYPOINTS_RESULT.name,
}
"""Topics of goals, which are repeated at the begin of each file until there is a result on the topic given here."""

SAMPLED = frozenset({topics.LOCAL_COSTMAP.name, topics.LOCAL_FOOTPRINT.name, topics.GLOBAL_COSTMAP.name})
"""Topics that the clone computes only for subscribers: one message of each is taken every `SAMPLE_PERIOD`."""

SAMPLE_PERIOD = 5.0
"""Period of the messages of `SAMPLED` [s]."""

PERIODS = {topics.PLAN.name: 2.0, topics.MOVE_BASE_FEEDBACK.name: 0.2}
"""Least times between two messages of topics that repeat what changes slowly [s]. A new goal restarts them."""

MOST_PAYLOAD = 16 << 20
"""Largest message that is recorded [bytes as JSON]."""


class RecordedBus(Protocol):
    """Topics of the executor, as the recorder hears them."""

    topics: dict[str, Topic]
    nodes: dict[str, Node]

    def tap(self, topic: str, callback: Callable[[str, Payload], None]) -> Callable[[], None]:
        """Subscribe to a topic; returns a function that unsubscribes."""
        ...

    def tap_published(self, callback: Callable[[str, Payload], None]) -> Callable[[], None]:
        """Call back for every message that nodes publish from now on; returns a function that ends it."""
        ...

    def published_by(self, node: Node) -> tuple[str, ...]:
        """Return the names of the topics that a node publishes."""
        ...

    def latched(self, topic: str) -> Payload | None:
        """Return the last message of a latched topic, or None."""
        ...


class Intake:
    """Hears topics of a clone.

    Parameters
    ----------
    bus : RecordedBus
    now : callable
        Returns the time [s since the epoch].
    take : callable
        Called with each entry.
    """

    def __init__(self, bus: RecordedBus, now: Callable[[], float], take: Callable[[BatchedMessage], None]) -> None:
        self._bus, self._now, self._take = bus, now, take
        self._untap: dict[str, Callable[[], None]] = {}
        self._known = 0
        self._globs: tuple[str, ...] = ()
        self._published: Payload | None = None
        self._untap_published: Callable[[], None] | None = None
        self._tapping = False
        self._goals: set[str] = set()
        self._due: dict[str, float] = {}
        self._sampled = float("-inf")
        self.too_large = 0

    def hear(self, globs: tuple[str, ...]) -> None:
        """Hear the topics that globs select, and no others; without globs, none.

        Topics that are declared later are heard from the next call on.
        """
        if globs == self._globs and len(self._bus.topics) == self._known:
            return
        self._hear_published(wanted=bool(globs))
        self._globs, self._known = globs, len(self._bus.topics)
        wanted = {name for name in self._bus.topics if name not in SAMPLED and selects(globs, name)}
        for name in self._untap.keys() - wanted:
            self._untap.pop(name)()
        self._tap(wanted - self._untap.keys())

    def _hear_published(self, *, wanted: bool) -> None:
        if wanted and self._untap_published is None:
            self._untap_published = self._bus.tap_published(self._note_published)
        elif not wanted and self._untap_published is not None:
            self._untap_published()
            self._untap_published = self._published = None

    def _tap(self, names: Collection[str]) -> None:
        published = {topic for node in self._bus.nodes.values() for topic in self._bus.published_by(node)}
        for name in names:
            # A latched message comes at once. The message of tf_static is merged from the clone's and the robot's.
            self._published = (
                None if name == topics.TF_STATIC.name or name not in published else self._bus.latched(name)
            )
            self._untap[name] = self._bus.tap(name, self._heard)
        self._published = None

    def repeat(self) -> None:
        """Hear the last messages of latched topics again: the recorder of the machine has forgotten them."""
        latched = [name for name in self._untap if self._bus.topics[name].latched]
        for name in latched:
            self._untap.pop(name)()
        self._tap(latched)

    def sample(self, elapsed: float) -> None:
        """Begin to hear topics of which only samples are taken, if it is time for it [s, monotonic]."""
        if elapsed - self._sampled < SAMPLE_PERIOD:
            return
        self._sampled = elapsed
        for name in SAMPLED - self._untap.keys():
            if name in self._bus.topics and selects(self._globs, name):
                # The message that the clone keeps for later subscribers is as old as the sample before.
                self._tapping = True
                self._untap[name] = self._bus.tap(name, self._heard_sample)
                self._tapping = False

    def _heard_sample(self, topic: str, message: Payload) -> None:
        if self._tapping or topic not in self._untap:
            return
        self._untap.pop(topic)()
        self._heard(topic, message)

    def _note_published(self, _topic: str, message: Payload) -> None:
        self._published = message  # it is delivered to the taps next

    def _heard(self, topic: str, message: Payload) -> None:
        if topic in PERIODS and not self._is_due(topic):
            return
        kind = self._bus.topics[topic]
        up = message is not self._published
        if kind.merge is not None:
            message = self._bus.latched(topic) or message
        content = message if isinstance(message, Message) else message.to_message()
        payload = encode(content)
        if len(payload) > MOST_PAYLOAD:
            self.too_large += 1
            return
        now = round(self._now() * 1e9)
        self._end_goals(topic, now)
        is_goal = up and topic in GOALS
        if is_goal:
            self._goals.add(topic)
            self._due.clear()
        latched = kind.latched and not kind.repeated
        self._take(
            BatchedMessage(
                topic, type_name(kind.type), up, latched, latched or is_goal, now, _stamp(content, now), payload
            )
        )

    def _is_due(self, topic: str) -> bool:
        now = self._now()
        if 0.0 < self._due.get(topic, 0.0) - now <= PERIODS[topic]:
            return False
        self._due[topic] = now + PERIODS[topic]
        return True

    def _end_goals(self, topic: str, now: int) -> None:
        for goal in [goal for goal in self._goals if GOALS[goal] == topic]:
            self._goals.remove(goal)
            self._take(BatchedMessage(goal, type_name(self._bus.topics[goal].type), True, False, True, now, now, b""))


def _stamp(message: Message, now: int) -> int:
    """Return the stamp of a message, or the time now if it has none [ns since the epoch]."""
    header = getattr(message, "header", None)
    if not isinstance(header, Header) or not (header.stamp.secs or header.stamp.nsecs):
        return now
    return max(header.stamp.secs * 10**9 + header.stamp.nsecs, 0)


# -- node ``recorder`` -------------------------------------------------------------------------------------------------

PERIOD = 0.5
"""Period at which messages are handed over [s]: if the clone is killed, those since are lost."""

MOST_SECONDS = 3600.0
"""Longest recording [s]."""

MOST_PENDING = 4 << 20
"""Size of the messages that wait at most, beyond which they are handed over at once [bytes]."""

Sink = Callable[[bytes], bool]
"""Called with a batch; returns whether the machine takes it."""


class RunningRecording(msgspec.Struct, frozen=True):
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
    bus : RecordedBus
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
        self, context: Context, bus: RecordedBus, parameters: RecorderParameters, about: Callable[[], About], sink: Sink
    ) -> None:
        super().__init__(context)
        self._parameters, self._about, self._sink = parameters, about, sink
        self._ring_globs = checked_globs(parameters.topics) if parameters.ring_minutes else ()
        self._intake = Intake(bus, context.now, self._take)
        self._entries: list[BatchedMessage] = []
        self._pending = self._messages = self._lost = 0
        self._recording: RunningRecording | None = None
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
        self._recording = RunningRecording(
            f"{datetime.fromtimestamp(now, UTC):%Y%m%dT%H%M%SZ}", now + request.seconds, globs
        )
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

    def _take(self, entry: BatchedMessage) -> None:
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

    def _batch(self, recording: str, entries: list[BatchedMessage]) -> Batch:
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
        self._recording = from_json(state, RunningRecording)
        self._intake.hear(self._globs())
