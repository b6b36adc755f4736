"""Node context: what an executor provides to one node, whose timers, jobs and calls end when the node leaves."""

import itertools
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from ppaas.errors import PPaaSError, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.nodes.base import Context, Job, Payload, Reply, Timer, Topic
from ppaas.nodes.run_times import RunTimes

if TYPE_CHECKING:
    from ppaas.nodes.base import Node

logger = logging.getLogger(__name__)

T = TypeVar("T")


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
