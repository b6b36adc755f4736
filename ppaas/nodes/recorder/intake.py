"""Intake of the recorder: topics of a clone that it hears, and their messages as entries of a batch."""

from collections.abc import Callable, Collection
from typing import Protocol

from ppaas.messages import encode, type_name
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.nodes import topics
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.recording.batches import Entry
from ppaas.recording.parameters import selects

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


class Bus(Protocol):
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
    bus : Bus
    now : callable
        Returns the time [s since the epoch].
    take : callable
        Called with each entry.
    """

    def __init__(self, bus: Bus, now: Callable[[], float], take: Callable[[Entry], None]) -> None:
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
            Entry(topic, type_name(kind.type), up, latched, latched or is_goal, now, _stamp(content, now), payload)
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
            self._take(Entry(goal, type_name(self._bus.topics[goal].type), True, False, True, now, now, b""))


def _stamp(message: Message, now: int) -> int:
    """Return the stamp of a message, or the time now if it has none [ns since the epoch]."""
    header = getattr(message, "header", None)
    if not isinstance(header, Header) or not (header.stamp.secs or header.stamp.nsecs):
        return now
    return max(header.stamp.secs * 10**9 + header.stamp.nsecs, 0)
