"""The graph: topics, services, timers and jobs among the nodes of one home.

It is as pure as its nodes. A home gives it two clocks and a ``Worker``, tells it of what comes from outside, and
asks it every now and then which timers are due.
"""

import heapq
import itertools
import logging
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.messages.message import Message
from ppaas.nodes.base import Checkpoint, Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.jobs import GraphJob, GraphTimer, Worker, run_inline
from ppaas.nodes.node_context import RunTimes, Tenancy

logger = logging.getLogger(__name__)

T = TypeVar("T")
N = TypeVar("N", bound=Node)
Tap = Callable[[str, Payload], None]
TopicWatch = Callable[[Node, str, Topic | None], None]
"""Told the node, the name, and the topic that it declared, or None when that is no more."""


class Graph:
    """The nodes of one home and what runs between them.

    Parameters
    ----------
    worker : Worker
        Runs jobs.
    clock, stamp_clock : callable
        Monotonic seconds for timers; seconds since the epoch for stamps.
    """

    def __init__(self, worker: Worker = run_inline, clock: Clock = monotonic, stamp_clock: Clock = epoch) -> None:
        self._worker = worker
        self._clock = clock
        self._stamp_clock = stamp_clock
        self.nodes: dict[str, Node] = {}
        self.times = RunTimes(clock)
        self._tenancies: dict[str, Tenancy] = {}
        self._overhearing: list[Tap] = []
        self.topics: dict[str, Topic] = {}
        self.services: dict[str, Service] = {}
        self._subscribers: dict[str, list[Node]] = {}
        self._servers: dict[str, Node] = {}
        self._with_goals: list[Node] = []
        self._taps: dict[str, list[Tap]] = {}
        self._owners: dict[str, Node] = {}
        self._watches: list[TopicWatch] = []
        self._latched: dict[str, Payload] = {}
        self._queue: deque[tuple[str, Payload]] = deque()
        self._draining = False
        self._timers: list[tuple[float, int, GraphTimer]] = []
        self._sequence = itertools.count()

    # -- nodes -----------------------------------------------------------------------------------------------------

    def add(self, make: Callable[[Context], N]) -> N:
        """Make a node in this home and connect its topics and services.

        Raises
        ------
        Conflict
            A node of that name, or a server of one of its services, is here already; or a topic has another type.
        """
        tenancy = Tenancy(self, self.times)
        node = make(tenancy)
        tenancy.node = node.name
        if node.name in self.nodes:
            raise Conflict(f"node {node.name!r} runs here already")
        for topic in (*node.subscribes, *node.publishes):
            self._declare(topic)
        for service in node.services:
            if service.name in self.services:
                raise Conflict(f"service {service.name!r} is offered already")
            self.services[service.name] = service
            self._servers[service.name] = node
        self.nodes[node.name] = node
        self._tenancies[node.name] = tenancy
        if type(node).busy is not Node.busy:
            self._with_goals.append(node)
        node.start()
        for topic in node.subscribes:
            self._subscribers.setdefault(topic.name, []).append(node)
            if topic.name in self._latched:
                node.on_message(topic.name, self._latched[topic.name])
        return node

    def remove(self, name: str) -> bytes | None:
        """Let a node leave; return its checkpoint. The topics that its class names stay known here.

        Raises
        ------
        NotFound
            No such node is here.
        """
        node = self.nodes.pop(name, None)
        if node is None:
            raise NotFound("node", name, list(self.nodes))
        state = node.checkpoint()
        self._tenancies.pop(name).end()
        self._with_goals = [other for other in self._with_goals if other is not node]
        for topic in node.subscribes:
            self._subscribers[topic.name] = [other for other in self._subscribers[topic.name] if other is not node]
        for service in node.services:
            del self.services[service.name], self._servers[service.name]
        for declared in [topic for topic, owner in self._owners.items() if owner is node]:
            self.undeclare(node, declared)
        return state

    def overhear(self, callback: Tap) -> None:
        """Hear all that nodes here publish from now on, and nothing that comes from outside."""
        self._overhearing.append(callback)

    def _declare(self, topic: Topic) -> None:
        known = self.topics.setdefault(topic.name, topic)
        if known.type is not topic.type:
            raise Conflict(f"topic {topic.name!r} is of {known.type.__name__}, not {topic.type.__name__}")
        if topic.latched:
            self.topics[topic.name] = topic

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

    @property
    def busy(self) -> bool:
        """Tell whether a node works for a goal."""
        return any(node.busy for node in self._with_goals)

    def checkpoints(self) -> list[Checkpoint]:
        """Return what the nodes need to go on elsewhere."""
        states = ((node.name, node.checkpoint()) for node in self.nodes.values())
        return [Checkpoint(name, state) for name, state in states if state is not None]

    def restore(self, checkpoints: list[Checkpoint]) -> None:
        """Let the nodes that are here go on from their checkpoints."""
        for checkpoint in checkpoints:
            node = self.nodes.get(checkpoint.node)
            if node is not None:
                node.restore(checkpoint.state)
        self._drain()

    # -- topics ----------------------------------------------------------------------------------------------------

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

    def tell(self, node: str, topic: str, message: Payload) -> None:
        """Tell one node alone what was published when it was not here; raises what the node does.

        Raises
        ------
        NotFound
            No such node is here.
        """
        if node not in self.nodes:
            raise NotFound("node", node, list(self.nodes))
        self.nodes[node].on_message(topic, message)
        self._drain()

    def latched(self, topic: str) -> Payload | None:
        """Return the last message of a latched topic, if there was one."""
        return self._latched.get(topic)

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

    # -- services --------------------------------------------------------------------------------------------------

    def service(self, name: str) -> Service:
        """Return a service of this home.

        Raises
        ------
        NotFound
            No node here offers it.
        """
        if name not in self.services:
            raise NotFound("service", name, list(self.services))
        return self.services[name]

    def call(self, service: str, request: Message, reply: Reply) -> None:
        """Call a service of this home; ``reply`` gets the response or the error, now or later."""
        server = self._servers.get(service)
        if server is None:
            reply(NotFound("service", service, list(self.services)))
            return

        def on_call(answer: Reply) -> None:
            self.times.run(server.name, partial(server.on_call, service, request, answer))

        self._tenancies[server.name].serve(on_call, reply)
        self._drain()

    # -- timers and jobs: the Context that nodes are given -----------------------------------------------------------

    def now(self) -> float:
        """Return seconds since the epoch."""
        return self._stamp_clock()

    def every(self, period: float, callback: Callable[[], None]) -> GraphTimer:
        """Call back every ``period`` seconds, for the first time after one."""
        timer = GraphTimer(period, callback)
        heapq.heappush(self._timers, (self._clock() + period, next(self._sequence), timer))
        return timer

    def run_due(self) -> float:
        """Fire the timers that are due; return the seconds until the next (infinity if there is none).

        A home that was held up does not fire a timer twice to catch up.
        """
        now = self._clock()
        while self._timers and self._timers[0][0] <= now:
            due, _, timer = heapq.heappop(self._timers)
            if timer.stopped:
                continue
            next_due = due + timer.period if due + timer.period > now else now + timer.period
            heapq.heappush(self._timers, (next_due, next(self._sequence), timer))
            timer.callback()
            self._drain()
        return max(self._timers[0][0] - self._clock(), 0.0) if self._timers else float("inf")

    def start(self, work: Callable[[Callable[[], bool]], T], done: Callable[[T | PPaaSError], None]) -> GraphJob:
        """Run ``work(cancelled)`` by the worker of this home."""
        job = GraphJob()

        def finish(result: Any) -> None:
            done(result)
            self._drain()

        self._worker(work, job.is_cancelled, finish)
        return job
