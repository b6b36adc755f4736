"""Topics, services, timers and jobs of a graph."""

from collections.abc import Callable
from typing import Any

import pytest

from ppaas.clock import ManualClock
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.messages import std_msgs, std_srvs
from ppaas.messages.message import Message
from ppaas.nodes.base import Checkpoint, Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.graph import Graph

IN = Topic("in", std_msgs.Float64)
OUT = Topic("out", std_msgs.Float64)
LAST = Topic("last", std_msgs.Float64, latched=True)


class Doubler(Node):
    """Publishes the double of a number, rejects negative ones, and remembers the last."""

    name = "doubler"
    subscribes = (IN,)
    publishes = (OUT, LAST)
    services = (Service("reset", std_srvs.EmptyService),)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.last = 0.0

    def on_message(self, topic: str, message: Payload) -> None:
        assert isinstance(message, std_msgs.Float64)
        if message.data < 0:
            raise InvalidInput("negative")
        self.last = 2 * message.data
        self.context.publish("out", std_msgs.Float64(self.last))
        self.context.publish("last", std_msgs.Float64(self.last))

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        self.last = 0.0
        reply(std_msgs.Empty())

    def checkpoint(self) -> bytes:
        return str(self.last).encode()

    def restore(self, state: bytes) -> None:
        self.last = float(state)


class Listener(Node):
    """Stores the messages of a topic."""

    name = "listener"
    subscribes = (OUT, LAST)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.heard: list[tuple[str, float]] = []

    def on_message(self, topic: str, message: Payload) -> None:
        assert isinstance(message, std_msgs.Float64)
        self.heard.append((topic, message.data))


def test_a_message_runs_from_node_to_node() -> None:
    graph = Graph()
    graph.add(Doubler)
    listener = graph.add(Listener)
    graph.inject("in", std_msgs.Float64(2.0))
    assert listener.heard == [("out", 4.0), ("last", 4.0)]


def test_a_latched_topic_gives_its_last_message_to_who_comes_later() -> None:
    graph = Graph()
    graph.add(Doubler)
    graph.inject("in", std_msgs.Float64(1.0))
    assert graph.add(Listener).heard == [("last", 2.0)]
    tapped: list[Payload] = []
    graph.tap("last", lambda _topic, message: tapped.append(message))
    graph.tap("out", lambda _topic, message: tapped.append(message))
    assert tapped == [std_msgs.Float64(2.0)]


def test_a_tap_ends_when_it_is_told_to() -> None:
    graph = Graph()
    graph.add(Doubler)
    tapped: list[Payload] = []
    untap = graph.tap("out", lambda _topic, message: tapped.append(message))
    graph.inject("in", std_msgs.Float64(1.0))
    untap()
    graph.inject("in", std_msgs.Float64(1.0))
    assert len(tapped) == 1


def test_a_refusal_reaches_who_sent_the_message() -> None:
    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(InvalidInput, match="negative"):
        graph.inject("in", std_msgs.Float64(-1.0))
    with pytest.raises(InvalidInput, match="Float64"):
        graph.inject("in", std_msgs.String("x"))
    with pytest.raises(NotFound, match="known: in, last, out"):
        graph.inject("nothing", std_msgs.Float64(1.0))


def test_two_nodes_of_one_name_or_service_conflict() -> None:
    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(Conflict, match="doubler"):
        graph.add(Doubler)


def test_a_topic_has_one_type() -> None:
    class Wrong(Node):
        name = "wrong"
        publishes = (Topic("in", std_msgs.String),)

    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(Conflict, match="Float64"):
        graph.add(Wrong)


def test_services_answer_and_unknown_ones_say_so() -> None:
    graph = Graph()
    doubler = graph.add(Doubler)
    graph.inject("in", std_msgs.Float64(3.0))
    answers: list[Payload | PPaaSError] = []
    graph.call("reset", std_msgs.Empty(), answers.append)
    graph.call("nothing", std_msgs.Empty(), answers.append)
    assert doubler.last == 0.0
    assert isinstance(answers[0], std_msgs.Empty) and isinstance(answers[1], NotFound)


def test_a_node_goes_on_in_another_home_from_its_checkpoint() -> None:
    first, second = Graph(), Graph()
    first.add(Doubler)
    moved = second.add(Doubler)
    first.inject("in", std_msgs.Float64(21.0))
    second.restore([*first.checkpoints(), Checkpoint("a node that is not here", b"{}")])
    assert moved.last == 42.0


def test_a_checkpoint_that_a_node_cannot_read_is_refused_by_name() -> None:
    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(InvalidInput, match=r"checkpoint of node 'doubler' cannot be read"):
        graph.restore([Checkpoint("doubler", b"of another release")])


def test_a_timer_fires_once_for_each_period_and_not_to_catch_up() -> None:
    clock = ManualClock()
    graph = Graph(clock=clock)
    fired: list[float] = []
    timer = graph.every(0.1, lambda: fired.append(clock.now))
    assert graph.run_due() == pytest.approx(0.1)
    clock.advance(0.1)
    graph.run_due()
    clock.advance(1.0)
    graph.run_due()
    assert len(fired) == 2
    timer.stop()
    clock.advance(1.0)
    assert graph.run_due() == float("inf")
    assert len(fired) == 2


def test_a_job_comes_back_with_its_result_its_error_or_its_cancellation() -> None:
    waiting: list[Callable[[], None]] = []

    def worker(work: Callable[..., Any], cancelled: Callable[[], bool], done: Callable[[Any], None]) -> None:
        waiting.append(lambda: done(work(cancelled)))

    graph = Graph(worker)
    results: list[object] = []
    graph.start(lambda cancelled: cancelled(), results.append)
    graph.start(lambda cancelled: cancelled(), results.append).cancel()
    assert results == []
    for run in waiting:
        run()
    assert results == [False, True]

    def fail(_cancelled: Callable[[], bool]) -> None:
        raise InvalidInput("no")

    Graph().start(fail, results.append)
    assert isinstance(results[-1], InvalidInput)


# -- topics that come and go -------------------------------------------------------------------------------------------

MORE = Topic("more", std_msgs.Float64, latched=True)


def test_a_topic_that_is_declared_at_run_time_is_as_any_other_until_it_is_undeclared():
    graph, heard = Graph(), []
    doubler = graph.add(Doubler)
    with pytest.raises(NotFound):
        graph.publish("more", std_msgs.Float64(0.0))
    graph.declare(doubler, MORE)
    assert graph.published_by(doubler) == ("out", "last", "more")
    graph.publish("more", std_msgs.Float64(1.0))
    graph.tap("more", lambda _, message: heard.append(message.data))
    graph.publish("more", std_msgs.Float64(2.0))
    graph.undeclare(doubler, "more")
    assert graph.published_by(doubler) == ("out", "last")
    assert heard == [1.0, 2.0]
    graph.declare(doubler, MORE)
    graph.publish("more", std_msgs.Float64(3.0))
    assert (heard, graph.latched("more")) == ([1.0, 2.0], std_msgs.Float64(3.0)), "taps and what was latched are gone"


def test_what_is_on_its_way_when_its_topic_ends_is_lost_and_breaks_nothing():
    class Fickle(Doubler):
        name = "fickle"

        def on_message(self, topic: str, message: Payload) -> None:
            self.context.declare(self, MORE)
            self.context.publish("more", std_msgs.Float64(1.0))
            self.context.undeclare(self, "more")
            self.context.publish("out", std_msgs.Float64(2.0))

    graph = Graph()
    graph.add(Fickle)
    listener = graph.add(Listener)
    graph.inject("in", std_msgs.Float64(0.0))
    assert listener.heard == [("out", 2.0)]


def test_a_node_ends_only_the_topics_that_it_declared_and_takes_no_name_that_is_taken():
    graph = Graph()
    doubler, listener = graph.add(Doubler), graph.add(Listener)
    graph.declare(doubler, MORE)
    with pytest.raises(Conflict, match="more"):
        graph.declare(listener, MORE)
    for node, name in ((listener, "more"), (doubler, "out"), (doubler, "nothing")):
        with pytest.raises(NotFound):
            graph.undeclare(node, name)


def test_a_topic_is_heard_while_a_node_or_somebody_outside_listens():
    graph = Graph()
    graph.add(Doubler)
    assert [graph.has_subscribers(topic) for topic in ("in", "out", "nothing")] == [True, False, False]
    untap = graph.tap("out", lambda *_: None)
    assert graph.has_subscribers("out")
    untap()
    assert not graph.has_subscribers("out")


def test_who_watches_is_told_of_topics_that_come_and_go_and_whose_they_are():
    graph, told = Graph(), []
    doubler = graph.add(Doubler)
    graph.watch(lambda *news: told.append(news))
    graph.declare(doubler, MORE)
    graph.undeclare(doubler, "more")
    assert told == [(doubler, "more", MORE), (doubler, "more", None)]
