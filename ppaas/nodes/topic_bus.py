"""Topic bus: delivers published messages to the subscribers and taps of one executor."""

import logging
from collections import deque
from collections.abc import Callable
from functools import partial

from ppaas.bounded import BoundedDict
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.listener_faults import ListenerFaults
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.run_times import RunTimes

logger = logging.getLogger(__name__)

MOST_REFUSALS = 256
"""Largest number of kinds of refusals, by topic, that are remembered; one that is forgotten is a warning again."""

Tap = Callable[[str, Payload], None]
Gate = Callable[[Payload], Payload]
"""Called with each message of a topic; returns the message that is delivered in its place."""

TopicWatch = Callable[[Node, str, Topic | None], None]
"""Called with the node, the name, and the topic that the node declared, or None if it was undeclared."""


class TopicBus:
    """Topics of one executor and their subscribers.

    Parameters
    ----------
    times : RunTimes
        Records the run times of subscribers.
    """

    def __init__(self, times: RunTimes) -> None:
        self.times = times
        self.topics: dict[str, Topic] = {}
        self._published_taps: list[Tap] = []
        self._subscribers: dict[str, list[Node]] = {}
        self._taps: dict[str, list[Tap]] = {}
        self._owners: dict[str, Node] = {}
        self._watches: list[TopicWatch] = []
        self._latched: dict[str, Payload] = {}
        self._gates: dict[str, Gate] = {}
        self._queue: deque[tuple[str, Payload]] = deque()
        self._draining = False
        self._faults = ListenerFaults(logger)
        self._refusals: BoundedDict[tuple[str, str], None] = BoundedDict(MOST_REFUSALS)

    # -- declarations, subscribers and taps ----------------------------------------------------------------------------

    def topic(self, name: str) -> Topic:
        """Return a topic by its name.

        Raises
        ------
        NotFound
            No node publishes or subscribes to it.
        """
        if name not in self.topics:
            raise NotFound("topic", name, list(self.topics))
        return self.topics[name]

    def declare(self, node: Node, topic: Topic) -> None:
        """Declare a topic that a node publishes in addition to its class's topics, until ``undeclare``.

        Raises
        ------
        Conflict
            A topic of that name exists.
        """
        if topic.name in self.topics:
            raise Conflict(f"topic {topic.name!r} already exists")
        self.topics[topic.name] = topic
        self._owners[topic.name] = node
        for watch in self._watches:
            self._faults.call("a watch of topics", watch, node, topic.name, topic)

    def undeclare(self, node: Node, name: str) -> None:
        """Remove a topic that this node declared, with its queued messages and its taps.

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
            self._faults.call("a watch of topics", watch, node, name, None)

    def watch(self, callback: TopicWatch) -> None:
        """Call back for each topic that is declared or undeclared from now on."""
        self._watches.append(callback)

    def published_by(self, node: Node) -> tuple[str, ...]:
        """Return the names of the topics that a node publishes, including declared ones."""
        declared = [topic for topic, owner in self._owners.items() if owner is node]
        return (*(topic.name for topic in node.publishes), *declared)

    def has_subscribers(self, topic: str) -> bool:
        """Return whether a topic has subscribed nodes or taps."""
        return bool(self._subscribers.get(topic) or self._taps.get(topic))

    def has_taps(self, topic: str) -> bool:
        """Return whether a topic has taps: subscribers outside the graph."""
        return bool(self._taps.get(topic))

    def tap_published(self, callback: Tap) -> Callable[[], None]:
        """Call back for every message that nodes publish from now on, but not for injected ones.

        Returns a function that ends it.
        """
        self._published_taps.append(callback)
        return lambda: self._published_taps.remove(callback)

    def tap(self, topic: str, callback: Tap) -> Callable[[], None]:
        """Subscribe to a topic from outside the graph; returns a function that unsubscribes.

        A latched topic delivers its last message at once.

        Raises
        ------
        NotFound
            No node publishes or subscribes to the topic.
        """
        self.topic(topic)
        taps = self._taps.setdefault(topic, [])
        taps.append(callback)
        if topic in self._latched:
            callback(topic, self._latched[topic])
        return lambda: taps.remove(callback)

    def gate(self, topic: str, gate: Gate) -> None:
        """Deliver on a topic what a function returns for each message, published by a node or injected."""
        self._gates[topic] = gate

    def _passed(self, topic: str, message: Payload) -> Payload:
        gate = self._gates.get(topic)
        return message if gate is None else gate(message)

    def _declare(self, topic: Topic) -> None:
        known = self.topics.setdefault(topic.name, topic)
        if known.type is not topic.type:
            raise Conflict(f"topic {topic.name!r} has type {known.type.__name__}, not {topic.type.__name__}")
        if topic.latched:
            self.topics[topic.name] = topic

    def _subscribe(self, node: Node) -> None:
        for topic in node.subscribes:
            self._subscribers.setdefault(topic.name, []).append(node)
            if topic.name in self._latched:
                node.on_message(topic.name, self._latched[topic.name])

    def _unsubscribe(self, node: Node) -> None:
        """Remove the subscriptions of a node, the topics that it declared, and its messages that it would repeat."""
        for topic in node.publishes:
            if topic.repeated:
                self.forget(topic.name)
        for topic in node.subscribes:
            self._subscribers[topic.name] = [other for other in self._subscribers[topic.name] if other is not node]
        for declared in [topic for topic, owner in self._owners.items() if owner is node]:
            self.undeclare(node, declared)

    # -- messages ------------------------------------------------------------------------------------------------------

    def publish(self, topic: str, message: Payload) -> None:
        """Publish a message of a node. Errors of subscribers are logged, since they are not the publisher's fault.

        Raises
        ------
        NotFound
            No node publishes or subscribes to the topic.
        """
        self.topic(topic)
        self._queue.append((topic, message))
        if not self._draining:
            self._drain()

    def inject(self, topic: str, message: Payload) -> None:
        """Publish a message from outside the graph.

        Raises
        ------
        NotFound
            No node publishes or subscribes to the topic.
        InvalidInput
            The message has another type.
        PPaaSError
            A subscriber rejects the message, or has failed; all others have got it.
        """
        expected = self.topic(topic).type
        if isinstance(message, Message) and not isinstance(message, expected):
            raise InvalidInput(f"topic {topic!r} has type {expected.__name__}, not {type(message).__name__}")
        refusals: list[PPaaSError] = []
        self._deliver(topic, self._passed(topic, message), refusals.append)
        self._drain()
        if refusals:
            raise refusals[0]

    def forget(self, topic: str) -> None:
        """Drop the last message of a latched topic; later subscribers get the next one."""
        self._latched.pop(topic, None)

    def latch(self, topic: str, message: Payload) -> None:
        """Replace the last message of a latched topic for later subscribers; current ones do not get it.

        Raises
        ------
        NotFound
            No node publishes or subscribes to the topic.
        """
        self.topic(topic)
        self._latched[topic] = message

    def latched(self, topic: str) -> Payload | None:
        """Return the last message of a latched topic, or None."""
        return self._latched.get(topic)

    def _drain(self) -> None:
        if self._draining:
            return
        self._draining = True
        try:
            while self._queue:
                topic, message = self._queue.popleft()
                message = self._passed(topic, message)
                for hear in tuple(self._published_taps):
                    self._faults.call("a tap of all topics", hear, topic, message)
                self._deliver(topic, message, partial(self._note_refusal, topic))
        finally:
            self._draining = False

    def _note_refusal(self, topic: str, error: PPaaSError) -> None:
        """Log a refusal of a message between nodes: the first of each kind and topic as a warning."""
        level = logging.DEBUG if (topic, error.slug) in self._refusals else logging.WARNING
        self._refusals[topic, error.slug] = None
        logger.log(level, "a message on %s is refused: %s", topic, error)

    def _deliver(self, topic: str, message: Payload, refused: Callable[[PPaaSError], None]) -> None:
        known = self.topics.get(topic)
        if known is None:  # undeclared after it was published
            return
        if known.latched:
            self._latch(known, message)
        for node in self._subscribers.get(topic, ()):
            try:
                self.times.run(node.name, partial(node.on_message, topic, message))
            except PPaaSError as error:
                refused(error)
            except Exception as error:  # noqa: BLE001 - it is logged by `note`
                refused(self._faults.note(f"node {node.name!r} on topic {topic!r}", error))
        for tap in tuple(self._taps.get(topic, ())):
            try:
                tap(topic, message)
            except Exception as error:  # noqa: BLE001 - likewise
                self._faults.note(f"a tap of topic {topic!r}", error)

    def _latch(self, topic: Topic, message: Payload) -> None:
        """Store the message for later subscribers."""
        earlier = self._latched.get(topic.name)
        self._latched[topic.name] = message if topic.merge is None or earlier is None else topic.merge(earlier, message)
