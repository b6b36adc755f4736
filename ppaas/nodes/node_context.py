"""What a home gives one node, for as long as it lives there: its timers, jobs and calls end when it leaves."""

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from ppaas.errors import PPaaSError, Unavailable
from ppaas.nodes.base import Context, Job, Payload, Reply, Timer, Topic
from ppaas.nodes.run_times import RunTimes

if TYPE_CHECKING:
    from ppaas.nodes.base import Node

T = TypeVar("T")


class _HeldTimer:
    def __init__(self, timer: Timer, among: set[Timer]) -> None:
        self._timer = timer
        self._among = among

    def stop(self) -> None:
        self._timer.stop()
        self._among.discard(self)


class NodeContext:
    """The context of one node: its home's, until the node leaves.

    Parameters
    ----------
    home : Context
        Where it lives.
    times : RunTimes
        Of that home.

    Attributes
    ----------
    node : str
        Its name.
    """

    def __init__(self, home: Context, times: RunTimes) -> None:
        self.node = ""
        self._home = home
        self._times = times
        self._gone = False
        self._timers: set[Timer] = set()
        self._jobs: set[Job] = set()
        self._numbers = itertools.count()
        self._calls: dict[int, Reply] = {}

    def end(self) -> None:
        """Stop all that the node began; whatever it says from now on is not heard, and who asked it is told so."""
        self._gone = True
        for timer in tuple(self._timers):
            timer.stop()
        for job in self._jobs:
            job.cancel()
        calls, self._calls = self._calls, {}
        for reply in calls.values():
            reply(Unavailable(f"{self.node} left for another home while it worked on this; call again"))

    def serve(self, on_call: Callable[[Reply], None], reply: Reply) -> None:
        """Let the node answer a call, now or later; ``reply`` is called once, even if the node leaves before it has."""
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
        """Return seconds since the epoch, for stamps."""
        return self._home.now()

    def publish(self, topic: str, message: Payload) -> None:
        """Publish on a topic that the node declared."""
        if not self._gone:
            self._home.publish(topic, message)

    def declare(self, node: "Node", topic: Topic) -> None:
        """Let the node publish a topic that its class does not name; ``Conflict`` where the name is taken."""
        self._home.declare(node, topic)

    def undeclare(self, node: "Node", name: str) -> None:
        """End a topic that the node declared."""
        self._home.undeclare(node, name)

    def is_heard(self, topic: str) -> bool:
        """Tell whether anybody hears a topic now."""
        return self._home.is_heard(topic)

    def start(self, work: Callable[[Callable[[], bool]], T], done: Callable[[T | PPaaSError], None]) -> Job:
        """Run ``work(cancelled)`` off the node's thread; ``done`` hears of it unless the node has left."""
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
            if not self._gone:
                done(result)

        job = self._home.start(timed, finish)
        if not ended:
            self._jobs.add(job)
        return job

    def every(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call back every ``period`` seconds, on the node's thread, while the node is here."""
        timer = _HeldTimer(self._home.every(period, lambda: self._times.run(self.node, callback)), self._timers)
        self._timers.add(timer)
        return timer
