"""Node context: timers and jobs end when a node leaves, and run times are recorded by node."""

from collections.abc import Callable
from typing import Any

import pytest

from ppaas.clock import ManualClock
from ppaas.errors import NotFound, PPaaSError, Unavailable
from ppaas.messages import std_srvs
from ppaas.messages.base import std_msgs
from ppaas.messages.base.message import Empty, Message
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import Work

IN, OUT = Topic("in", std_msgs.Float64), Topic("out", std_msgs.Float64)


class Counter(Node):
    """Counts the ticks of its timer, in a job that the test has to run."""

    name = "counter"
    subscribes = (IN,)
    publishes = (OUT,)
    services = (Service("count", std_srvs.Trigger),)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.ticks = 0
        self.counted: list[object] = []

    @property
    def busy(self) -> bool:
        return True

    def start(self) -> None:
        self.timer = self.context.every(1.0, self.tick)

    def tick(self) -> None:
        self.ticks += 1
        self.context.publish("out", std_msgs.Float64(self.ticks))

    def on_message(self, topic: str, message: Payload) -> None:
        self.job = self.context.start(lambda cancelled: cancelled(), self.counted.append)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        reply(std_srvs.TriggerResponse(True, str(self.ticks)))

    def checkpoint(self) -> bytes:
        return str(self.ticks).encode()

    def restore(self, state: bytes) -> None:
        self.ticks = int(state)


class ManualWorker:
    """A worker that runs jobs when the test says so."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], None]] = []

    def __call__(self, work: Work[Any], cancelled: Callable[[], bool], done: Callable[[Any], None]) -> None:
        self.waiting.append(lambda: done(work(cancelled)))


def test_removed_node_is_disconnected_and_can_be_added_again() -> None:
    clock, worker = ManualClock(), ManualWorker()
    graph = Graph(worker, clock=clock)
    counter = graph.add(Counter)
    heard: list[Payload] = []
    graph.tap("out", lambda _, message: heard.append(message))
    clock.advance(1.0)
    graph.run_due()
    graph.inject("in", std_msgs.Float64(1.0))
    assert graph.remove("counter") == b"1"
    clock.advance(1.0)
    graph.run_due()
    counter.tick()
    [job] = worker.waiting
    job()
    graph.inject("in", std_msgs.Float64(1.0))
    assert (heard, counter.counted, worker.waiting) == ([std_msgs.Float64(1.0)], [], [job])
    assert (graph.busy, graph.services, list(graph.nodes)) == (False, {}, [])
    again = graph.add(Counter)
    clock.advance(1.0)
    graph.run_due()
    assert again.ticks == 1
    assert len(heard) == 2, "subscribers of the topic stay subscribed"


def test_job_of_a_removed_node_is_cancelled() -> None:
    worker, seen = ManualWorker(), []

    class Asking(Counter):
        def on_message(self, topic: str, message: Payload) -> None:
            self.context.start(lambda cancelled: seen.append(cancelled()), self.counted.append)

    graph = Graph(worker)
    graph.add(Asking)
    graph.inject("in", std_msgs.Float64(1.0))
    graph.remove("counter")
    worker.waiting[0]()
    assert seen == [True]


def test_pending_calls_of_a_removed_node_are_answered_once() -> None:
    open_replies: list[Reply] = []
    answers: list[Payload | PPaaSError] = []

    class Slow(Counter):
        def on_call(self, service: str, request: Message, reply: Reply) -> None:
            if open_replies:
                open_replies.append(reply)
                raise ZeroDivisionError
            open_replies.append(reply)

    graph = Graph()
    graph.add(Slow)
    graph.call("count", Empty(), answers.append)
    with pytest.raises(ZeroDivisionError):
        graph.call("count", Empty(), answers.append)
    assert answers == []
    graph.remove("counter")
    [error] = answers
    assert isinstance(error, Unavailable)
    assert "node 'counter' moved between cloud and robot" in str(error)
    for reply in open_replies:
        reply(std_srvs.TriggerResponse(True))
    assert answers == [error]


def test_unknown_node_cannot_be_removed() -> None:
    with pytest.raises(NotFound, match="counter"):
        Graph().remove("counter")


def test_tap_published_skips_injected_messages() -> None:
    clock = ManualClock()
    graph = Graph(clock=clock)
    graph.add(Counter)
    heard: list[tuple[str, Payload]] = []
    untap = graph.tap_published(lambda topic, message: heard.append((topic, message)))
    graph.inject("out", std_msgs.Float64(7.0))
    clock.advance(1.0)
    graph.run_due()
    assert heard == [("out", std_msgs.Float64(1.0))]
    untap()
    clock.advance(1.0)
    graph.run_due()
    assert heard == [("out", std_msgs.Float64(1.0))]


def test_run_times_exclude_time_in_other_nodes() -> None:
    clock = ManualClock()

    class Slow(Counter):
        def on_message(self, topic: str, message: Payload) -> None:
            clock.advance(2.0)
            self.context.publish("out", std_msgs.Float64(0.0))
            clock.advance(1.0)

    class Other(Node):
        name = "other"
        subscribes = (OUT,)

        def on_message(self, topic: str, message: Payload) -> None:
            clock.advance(5.0)

    graph = Graph(clock=clock)
    graph.add(Slow)
    graph.add(Other)
    graph.inject("in", std_msgs.Float64(1.0))
    assert graph.times.take() == {"counter": (1, 3.0), "other": (1, 5.0)}
    assert graph.times.take() == {}


def test_stopped_timer_is_not_kept() -> None:
    graph = Graph(clock=ManualClock())
    counter = graph.add(Counter)
    for _ in range(3):
        counter.context.every(1.0, counter.tick).stop()
    assert len(counter.context._timers) == 1  # type: ignore[attr-defined]  # nothing else can tell


def test_job_error_reaches_the_node() -> None:
    def work(cancelled: Callable[[], bool]) -> None:
        raise PPaaSError("no")

    graph = Graph()
    counter = graph.add(Counter)
    counter.context.start(work, counter.counted.append)
    assert isinstance(counter.counted[0], PPaaSError)
