"""Topics among the nodes of one home: what is published reaches subscribers, taps and who overhears."""

import logging
from collections import deque
from collections.abc import Callable
from functools import partial

from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.messages.message import Message
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.run_times import RunTimes

logger = logging.getLogger(__name__)

Tap = Callable[[str, Payload], None]
TopicWatch = Callable[[Node, str, Topic | None], None]
"""Told the node, the name, and the topic that it declared, or None when that is no more."""


class TopicBus:
    """Topics of one home, and who hears them.

    Parameters
    ----------
    times : RunTimes
        How long subscribers take.
    """

    def __init__(self, times: RunTimes) -> None:
        self.times = times
        self.topics: dict[str, Topic] = {}
        self._overhearing: list[Tap] = []
        self._subscribers: dict[str, list[Node]] = {}
        self._taps: dict[str, list[Tap]] = {}
        self._owners: dict[str, Node] = {}
        self._watches: list[TopicWatch] = []
        self._latched: dict[str, Payload] = {}
        self._queue: deque[tuple[str, Payload]] = deque()
        self._draining = False

    # -- who declares, subscribes and listens --------------------------------------------------------------------------

    def topic(self, name: str) -> Topic:
        """Return a topic of this home.

        Raises
        ------
        NotFound
            No node here knows it.
        """
        if name not in self.topics:
            raise NotFound("topic", name, list(self.topics))
        return self.topics[name]

    def declare(self, node: Node, topic: Topic) -> None:
        """Let a node publish a topic that its class does not name, until ``undeclare``.

        Raises
        ------
        Conflict
            The name is taken.
        """
        if topic.name in self.topics:
            raise Conflict(f"topic {topic.name!r} is here already")
        self.topics[topic.name] = topic
        self._owners[topic.name] = node
        for watch in self._watches:
            watch(node, topic.name, topic)

    def undeclare(self, node: Node, name: str) -> None:
        """End a topic that this node declared: what is on its way is lost, and taps of it end.

        Raises
        ------
        NotFound
            The node declared no such topic.
        """
        if self._owners.get(name) is not node:
            raise NotFound("declared topic", name, [topic for topic, owner in self._owners.items() if owner is node])
        del self._owners[name], self.topics[name]
        self._taps.pop(name, None)
        self._latched.pop(name, None)
        for watch in self._watches:
            watch(node, name, None)

    def watch(self, callback: TopicWatch) -> None:
        """Hear of the topics that are declared and undeclared from now on."""
        self._watches.append(callback)

    def published_by(self, node: Node) -> tuple[str, ...]:
        """Return the names of the topics that a node publishes now."""
        declared = [topic for topic, owner in self._owners.items() if owner is node]
        return (*(topic.name for topic in node.publishes), *declared)

    def is_heard(self, topic: str) -> bool:
        """Tell whether a node or a tap hears a topic now."""
        return bool(self._subscribers.get(topic) or self._taps.get(topic))

    def overhear(self, callback: Tap) -> None:
        """Hear all that nodes here publish from now on, and nothing that comes from outside."""
        self._overhearing.append(callback)

    def tap(self, topic: str, callback: Tap) -> Callable[[], None]:
        """Hear a topic from outside; a latched one gives its last message at once. Returns what ends it.

        Raises
        ------
        NotFound
            No node here knows the topic.
        """
        self.topic(topic)
        taps = self._taps.setdefault(topic, [])
        taps.append(callback)
        if topic in self._latched:
            callback(topic, self._latched[topic])
        return lambda: taps.remove(callback)

    def _declare(self, topic: Topic) -> None:
        known = self.topics.setdefault(topic.name, topic)
        if known.type is not topic.type:
            raise Conflict(f"topic {topic.name!r} is of {known.type.__name__}, not {topic.type.__name__}")
        if topic.latched:
            self.topics[topic.name] = topic

    def _subscribe(self, node: Node) -> None:
        for topic in node.subscribes:
            self._subscribers.setdefault(topic.name, []).append(node)
            if topic.name in self._latched:
                node.on_message(topic.name, self._latched[topic.name])

    def _unsubscribe(self, node: Node) -> None:
        """End what a node hears, and the topics that it declared."""
        for topic in node.subscribes:
            self._subscribers[topic.name] = [other for other in self._subscribers[topic.name] if other is not node]
        for declared in [topic for topic, owner in self._owners.items() if owner is node]:
            self.undeclare(node, declared)

    # -- what is published ---------------------------------------------------------------------------------------------

    def publish(self, topic: str, message: Payload) -> None:
        """Publish from a node of this home. What a subscriber raises is logged: it is no fault of the publisher.

        Raises
        ------
        NotFound
            No node here declared the topic.
        """
        self.topic(topic)
        self._queue.append((topic, message))
        if not self._draining:
            self._drain()

    def inject(self, topic: str, message: Payload) -> None:
        """Publish from outside.

        Raises
        ------
        NotFound
            No node here knows the topic.
        InvalidInput
            The message is of another type, or a subscriber refuses it.
        """
        expected = self.topic(topic).type
        if isinstance(message, Message) and not isinstance(message, expected):
            raise InvalidInput(f"topic {topic!r} takes {expected.__name__}, not {type(message).__name__}")
        refusals: list[PPaaSError] = []
        self._deliver(topic, message, refusals.append)
        self._drain()
        if refusals:
            raise refusals[0]

    def latched(self, topic: str) -> Payload | None:
        """Return the last message of a latched topic, if there was one."""
        return self._latched.get(topic)

    def _drain(self) -> None:
        if self._draining:
            return
        self._draining = True
        try:
            while self._queue:
                topic, message = self._queue.popleft()
                for hear in self._overhearing:
                    hear(topic, message)
                self._deliver(topic, message, lambda error: logger.warning("%s", error))
        finally:
            self._draining = False

    def _deliver(self, topic: str, message: Payload, refused: Callable[[PPaaSError], None]) -> None:
        known = self.topics.get(topic)
        if known is None:  # undeclared since it was published
            return
        if known.latched:
            self._latched[topic] = message
        for node in self._subscribers.get(topic, ()):
            try:
                self.times.run(node.name, partial(node.on_message, topic, message))
            except PPaaSError as error:
                refused(error)
        for tap in tuple(self._taps.get(topic, ())):
            tap(topic, message)
