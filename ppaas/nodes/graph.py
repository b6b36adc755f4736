"""Graph: connects the nodes of one executor by topics, services, timers and jobs, through a context for each.

Like its nodes it does no I/O. The executor provides two clocks and a ``Worker``, passes in messages and calls from
outside, and calls ``run_due`` for the timers.
"""

import heapq
import itertools
import logging
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Checkpoint, Context, Job, Node, Payload, Reply, Service, Timer, Topic
from ppaas.nodes.jobs import GraphJob, GraphTimer, Worker, run_inline
from ppaas.nodes.run_times import RunTimes
from ppaas.nodes.topic_bus import TopicBus

if TYPE_CHECKING:
    from ppaas.nodes.base import Node


logger = logging.getLogger(__name__)

T = TypeVar("T")


# -- node context ------------------------------------------------------------------------------------------------------


class _HeldTimer:
    def __init__(self, timer: Timer, among: set[Timer]) -> None:
        self._timer = timer
        self._among = among

    def stop(self) -> None:
        self._timer.stop()
        self._among.discard(self)


class NodeContext:
    """Context of one node. It passes everything to the executor until the node leaves.

    Parameters
    ----------
    executor : Context
        The graph in which the node runs.
    times : RunTimes
        Run times of the nodes of that graph.

    Attributes
    ----------
    node : str
        Name of the node.
    """

    def __init__(self, executor: Context, times: RunTimes) -> None:
        self.node = ""
        self._executor = executor
        self._times = times
        self._ended = False
        self._timers: set[Timer] = set()
        self._jobs: set[Job] = set()
        self._numbers = itertools.count()
        self._calls: dict[int, Reply] = {}
        self._faults = ListenerFaults(logger)

    def end(self) -> None:
        """Stop timers and jobs, drop what the node publishes from now on, and fail its open calls."""
        self._ended = True
        for timer in tuple(self._timers):
            timer.stop()
        for job in self._jobs:
            job.cancel()
        calls, self._calls = self._calls, {}
        moved = Unavailable(f"node {self.node!r} moved between cloud and robot during the call; call again")
        for reply in calls.values():
            self._faults.call(f"a caller of node {self.node!r}", reply, moved)

    def serve(self, on_call: Callable[[Reply], None], reply: Reply) -> None:
        """Ask the node to answer a call, now or later; ``reply`` is called once, even if the node leaves."""
        number = next(self._numbers)
        self._calls[number] = reply

        def answer(result: Payload | PPaaSError) -> None:
            waiting = self._calls.pop(number, None)
            if waiting is not None:
                waiting(result)

        try:
            on_call(answer)
        except PPaaSError as error:
            answer(error)
        except Exception:
            self._calls.pop(number, None)
            raise

    def now(self) -> float:
        """Return the time for stamps, in seconds since the epoch."""
        return self._executor.now()

    def elapsed(self) -> float:
        """Return monotonic seconds, for durations."""
        return self._executor.elapsed()

    def publish(self, topic: str, message: Payload) -> None:
        """Publish on a topic that the node declared."""
        if not self._ended:
            self._executor.publish(topic, message)

    def declare(self, node: "Node", topic: Topic) -> None:
        """Declare a topic of the node in addition to its class's topics; raises ``Conflict`` if the name exists."""
        self._executor.declare(node, topic)

    def undeclare(self, node: "Node", name: str) -> None:
        """Remove a topic that the node declared."""
        self._executor.undeclare(node, name)

    def forget(self, topic: str) -> None:
        """Drop the last message of a latched topic."""
        if not self._ended:
            self._executor.forget(topic)

    def latch(self, topic: str, message: Payload) -> None:
        """Replace the last message of a latched topic for later subscribers; current ones do not get it."""
        if not self._ended:
            self._executor.latch(topic, message)

    def has_subscribers(self, topic: str) -> bool:
        """Return whether a topic has subscribers now."""
        return self._executor.has_subscribers(topic)

    def start(self, work: Callable[[Callable[[], bool]], T], done: Callable[[T | PPaaSError], None]) -> Job:
        """Run ``work(cancelled)`` outside the node's thread; ``done`` is called unless the node has left."""
        taken = 0.0
        ended = False
        job: Job | None = None

        def timed(cancelled: Callable[[], bool]) -> T:
            nonlocal taken
            began = self._times.clock()
            try:
                return work(cancelled)
            finally:
                taken = self._times.clock() - began

        def finish(result: T | PPaaSError) -> None:
            nonlocal ended
            ended = True
            if job is not None:
                self._jobs.discard(job)
            self._times.add(self.node, taken)
            if not self._ended:
                done(result)

        job = self._executor.start(timed, finish)
        if not ended:
            self._jobs.add(job)
        return job

    def every(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call back every ``period`` seconds in the node's thread, until the node leaves."""
        timer = _HeldTimer(self._executor.every(period, lambda: self._times.run(self.node, callback)), self._timers)
        self._timers.add(timer)
        return timer


# -- graph -------------------------------------------------------------------------------------------------------------

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

    def restore(self, checkpoints: list[Checkpoint], *, of_other_map: bool = False) -> None:
        """Restore the nodes from their checkpoints; checkpoints of other nodes are ignored.

        With ``of_other_map``, the checkpoints were made on another map, and what belongs to that is left out.

        Raises
        ------
        InvalidInput
            A node cannot read its checkpoint, for example because another release wrote it.
        """
        for checkpoint in checkpoints:
            node = self.nodes.get(checkpoint.node)
            if node is not None:
                _restore(node, checkpoint.state, of_other_map=of_other_map)
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


def _restore(node: Node, state: bytes, *, of_other_map: bool) -> None:
    try:
        if of_other_map:
            node.carry_over(state)
        else:
            node.restore(state)
    except (msgspec.MsgspecError, ValueError) as error:
        text = f"the checkpoint of node {node.name!r} cannot be read, perhaps because another release wrote it: {error}"
        raise InvalidInput(text) from error
