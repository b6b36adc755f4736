"""Graph: connects the nodes of one executor by topics, services, timers and jobs.

Like its nodes it does no I/O. The executor provides two clocks and a ``Worker``, passes in messages and calls from
outside, and calls ``run_due`` for the timers.
"""

import heapq
import itertools
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import msgspec

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Checkpoint, Context, Node, Payload, Reply, Service
from ppaas.nodes.jobs import GraphJob, GraphTimer, Worker, run_inline
from ppaas.nodes.node_context import NodeContext
from ppaas.nodes.run_times import RunTimes
from ppaas.nodes.topic_bus import TopicBus

T = TypeVar("T")
N = TypeVar("N", bound=Node)


class Graph(TopicBus):
    """Nodes of one executor, with their topics, services, timers and jobs.

    Parameters
    ----------
    worker : Worker
        Runs jobs.
    clock, stamp_clock : callable
        Return monotonic seconds for timers, and seconds since the epoch for stamps.
    """

    def __init__(self, worker: Worker = run_inline, clock: Clock = monotonic, stamp_clock: Clock = epoch) -> None:
        super().__init__(RunTimes(clock))
        self._worker = worker
        self._clock = clock
        self._stamp_clock = stamp_clock
        self.nodes: dict[str, Node] = {}
        self._contexts: dict[str, NodeContext] = {}
        self.services: dict[str, Service] = {}
        self._servers: dict[str, Node] = {}
        self._with_goals: list[Node] = []
        self._timers: list[tuple[float, int, GraphTimer]] = []
        self._sequence = itertools.count()

    # -- nodes -----------------------------------------------------------------------------------------------------

    def add(self, make: Callable[[Context], N]) -> N:
        """Create a node, connect its topics and services, and start it.

        Raises
        ------
        Conflict
            A node of that name or one of its services exists, or a topic has another type.
        """
        context = NodeContext(self, self.times)
        node = make(context)
        context.node = node.name
        if node.name in self.nodes:
            raise Conflict(f"node {node.name!r} is already running")
        for topic in (*node.subscribes, *node.publishes):
            self._declare(topic)
        for service in node.services:
            if service.name in self.services:
                raise Conflict(f"service {service.name!r} is already offered by another node")
            self.services[service.name] = service
            self._servers[service.name] = node
        self.nodes[node.name] = node
        self._contexts[node.name] = context
        if type(node).busy is not Node.busy:
            self._with_goals.append(node)
        node.start()
        self._subscribe(node)
        return node

    def remove(self, name: str) -> bytes | None:
        """Remove a node and return its checkpoint. The topics of its class stay declared.

        Raises
        ------
        NotFound
            There is no such node.
        """
        node = self.nodes.pop(name, None)
        if node is None:
            raise NotFound("node", name, list(self.nodes))
        state = node.checkpoint()
        self._contexts.pop(name).end()
        self._with_goals = [other for other in self._with_goals if other is not node]
        for service in node.services:
            del self.services[service.name], self._servers[service.name]
        self._unsubscribe(node)
        return state

    @property
    def busy(self) -> bool:
        """Whether a node works on a goal."""
        return any(node.busy for node in self._with_goals)

    def checkpoints(self) -> list[Checkpoint]:
        """Return the checkpoints of all nodes that have one."""
        states = ((node.name, node.checkpoint()) for node in self.nodes.values())
        return [Checkpoint(name, state) for name, state in states if state is not None]

    def restore(self, checkpoints: list[Checkpoint]) -> None:
        """Restore the nodes from their checkpoints; checkpoints of other nodes are ignored.

        Raises
        ------
        InvalidInput
            A node cannot read its checkpoint, for example because another release wrote it.
        """
        for checkpoint in checkpoints:
            node = self.nodes.get(checkpoint.node)
            if node is not None:
                _restore(node, checkpoint.state)
        self._drain()

    @property
    def nodes_with_logs(self) -> list[Node]:
        """The nodes that have a log beside their checkpoint."""
        return [node for node in self.nodes.values() if node.keeps_log]

    def deliver_to(self, node: str, topic: str, message: Payload) -> None:
        """Deliver a message to one node only, such as one published while it ran elsewhere.

        Raises
        ------
        NotFound
            There is no such node.
        PPaaSError
            The node rejects the message.
        """
        if node not in self.nodes:
            raise NotFound("node", node, list(self.nodes))
        self.nodes[node].on_message(topic, message)
        self._drain()

    # -- services --------------------------------------------------------------------------------------------------

    def service(self, name: str) -> Service:
        """Return a service by its name.

        Raises
        ------
        NotFound
            No node offers it.
        """
        if name not in self.services:
            raise NotFound("service", name, list(self.services))
        return self.services[name]

    def call(self, service: str, request: Message, reply: Reply) -> None:
        """Call a service; ``reply`` is called with the response or the error, now or later."""
        server = self._servers.get(service)
        if server is None:
            reply(NotFound("service", service, list(self.services)))
            return

        def on_call(answer: Reply) -> None:
            self.times.run(server.name, partial(server.on_call, service, request, answer))

        self._contexts[server.name].serve(on_call, reply)
        self._drain()

    # -- timers and jobs, for the nodes' contexts ----------------------------------------------------------------------

    def now(self) -> float:
        """Return the time for stamps, in seconds since the epoch."""
        return self._stamp_clock()

    def elapsed(self) -> float:
        """Return monotonic seconds, for durations."""
        return self._clock()

    def every(self, period: float, callback: Callable[[], None]) -> GraphTimer:
        """Call back every ``period`` seconds, first after one period."""
        timer = GraphTimer(period, callback)
        heapq.heappush(self._timers, (self._clock() + period, next(self._sequence), timer))
        return timer

    def run_due(self) -> float:
        """Fire the timers that are due; return the seconds until the next one, or infinity.

        After a delay, a timer does not fire several times to catch up.
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
        """Run ``work(cancelled)`` with the worker of this executor."""
        job = GraphJob()

        def finish(result: Any) -> None:
            done(result)
            self._drain()

        self._worker(work, job.is_cancelled, finish)
        return job


def _restore(node: Node, state: bytes) -> None:
    try:
        node.restore(state)
    except (msgspec.MsgspecError, ValueError) as error:
        text = f"the checkpoint of node {node.name!r} cannot be read, perhaps because another release wrote it: {error}"
        raise InvalidInput(text) from error
