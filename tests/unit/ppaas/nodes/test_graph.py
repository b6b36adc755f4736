"""Topics, services, timers and jobs of a graph."""

import logging
from collections.abc import Callable
from typing import Any

import pytest

from ppaas.clock import ManualClock
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.messages import std_srvs
from ppaas.messages.base import std_msgs
from ppaas.messages.base.message import Message
from ppaas.nodes import topic_bus
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


def test_message_passes_from_node_to_node() -> None:
    graph = Graph()
    graph.add(Doubler)
    listener = graph.add(Listener)
    graph.inject("in", std_msgs.Float64(2.0))
    assert listener.heard == [("out", 4.0), ("last", 4.0)]


def test_latched_topic_gives_its_last_message_to_late_subscribers() -> None:
    graph = Graph()
    graph.add(Doubler)
    graph.inject("in", std_msgs.Float64(1.0))
    assert graph.add(Listener).heard == [("last", 2.0)]
    tapped: list[Payload] = []
    graph.tap("last", lambda _topic, message: tapped.append(message))
    graph.tap("out", lambda _topic, message: tapped.append(message))
    assert tapped == [std_msgs.Float64(2.0)]


def test_tap_can_be_removed() -> None:
    graph = Graph()
    graph.add(Doubler)
    tapped: list[Payload] = []
    untap = graph.tap("out", lambda _topic, message: tapped.append(message))
    graph.inject("in", std_msgs.Float64(1.0))
    untap()
    graph.inject("in", std_msgs.Float64(1.0))
    assert len(tapped) == 1


def test_refusal_is_raised_to_the_sender() -> None:
    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(InvalidInput, match="negative"):
        graph.inject("in", std_msgs.Float64(-1.0))
    with pytest.raises(InvalidInput, match="Float64"):
        graph.inject("in", std_msgs.String("x"))
    with pytest.raises(NotFound, match="known: in, last, out"):
        graph.inject("nothing", std_msgs.Float64(1.0))


def test_second_node_of_the_same_name_conflicts() -> None:
    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(Conflict, match="doubler"):
        graph.add(Doubler)


def test_second_type_of_a_topic_conflicts() -> None:
    class Wrong(Node):
        name = "wrong"
        publishes = (Topic("in", std_msgs.String),)

    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(Conflict, match="Float64"):
        graph.add(Wrong)


def test_services_answer_and_unknown_ones_are_not_found() -> None:
    graph = Graph()
    doubler = graph.add(Doubler)
    graph.inject("in", std_msgs.Float64(3.0))
    answers: list[Payload | PPaaSError] = []
    graph.call("reset", std_msgs.Empty(), answers.append)
    graph.call("nothing", std_msgs.Empty(), answers.append)
    assert doubler.last == 0.0
    assert isinstance(answers[0], std_msgs.Empty) and isinstance(answers[1], NotFound)


def test_node_continues_in_another_graph_from_its_checkpoint() -> None:
    first, second = Graph(), Graph()
    first.add(Doubler)
    moved = second.add(Doubler)
    first.inject("in", std_msgs.Float64(21.0))
    second.restore([*first.checkpoints(), Checkpoint("a node that is not here", b"{}")])
    assert moved.last == 42.0


def test_unreadable_checkpoint_is_refused_with_its_nodes_name() -> None:
    graph = Graph()
    graph.add(Doubler)
    with pytest.raises(InvalidInput, match=r"checkpoint of node 'doubler' cannot be read"):
        graph.restore([Checkpoint("doubler", b"of another release")])


def test_timer_fires_once_per_period_without_catching_up() -> None:
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


def test_job_delivers_its_result_error_or_cancellation() -> None:
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


# -- topics declared at run time ---------------------------------------------------------------------------------------

MORE = Topic("more", std_msgs.Float64, latched=True)


def test_topic_declared_at_run_time_works_until_undeclared():
    graph, received = Graph(), []
    doubler = graph.add(Doubler)
    with pytest.raises(NotFound):
        graph.publish("more", std_msgs.Float64(0.0))
    graph.declare(doubler, MORE)
    assert graph.published_by(doubler) == ("out", "last", "more")
    graph.publish("more", std_msgs.Float64(1.0))
    graph.tap("more", lambda _, message: received.append(message.data))
    graph.publish("more", std_msgs.Float64(2.0))
    graph.undeclare(doubler, "more")
    assert graph.published_by(doubler) == ("out", "last")
    assert received == [1.0, 2.0]
    graph.declare(doubler, MORE)
    graph.publish("more", std_msgs.Float64(3.0))
    assert (received, graph.latched("more")) == ([1.0, 2.0], std_msgs.Float64(3.0)), (
        "taps and latched messages are gone"
    )


def test_message_in_flight_is_dropped_when_its_topic_is_undeclared():
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


def test_node_undeclares_only_topics_that_it_declared():
    graph = Graph()
    doubler, listener = graph.add(Doubler), graph.add(Listener)
    graph.declare(doubler, MORE)
    with pytest.raises(Conflict, match="more"):
        graph.declare(listener, MORE)
    for node, name in ((listener, "more"), (doubler, "out"), (doubler, "nothing")):
        with pytest.raises(NotFound):
            graph.undeclare(node, name)


def test_has_subscribers_counts_nodes_and_taps():
    graph = Graph()
    graph.add(Doubler)
    assert [graph.has_subscribers(topic) for topic in ("in", "out", "nothing")] == [True, False, False]
    untap = graph.tap("out", lambda *_: None)
    assert graph.has_subscribers("out")
    untap()
    assert not graph.has_subscribers("out")


def test_a_last_message_that_is_out_of_date_can_be_dropped() -> None:
    graph = Graph()
    doubler = graph.add(Doubler)
    graph.inject("in", std_msgs.Float64(1.0))
    for _ in range(2):
        doubler.context.forget("last")
        assert graph.latched("last") is None
    assert graph.add(Listener).heard == []
    graph.inject("in", std_msgs.Float64(2.0))
    assert graph.latched("last") == std_msgs.Float64(4.0)
    graph.remove("doubler")
    doubler.context.forget("last")
    assert graph.latched("last") == std_msgs.Float64(4.0), "a node that has left changes nothing"


def test_a_node_that_leaves_takes_the_messages_with_it_that_it_would_repeat() -> None:
    class Repeater(Doubler):
        publishes = (OUT, LAST._replace(repeated=True))

    graph = Graph()
    graph.add(Repeater)
    graph.inject("in", std_msgs.Float64(1.0))
    graph.remove("doubler")
    assert graph.latched("last") is None


def test_watcher_is_notified_of_declared_and_undeclared_topics():
    graph, events = Graph(), []
    doubler = graph.add(Doubler)
    graph.watch(lambda *news: events.append(news))
    graph.declare(doubler, MORE)
    graph.undeclare(doubler, "more")
    assert events == [(doubler, "more", MORE), (doubler, "more", None)]


class Faulty(Node):
    """Fails on each message."""

    name = "faulty"
    subscribes = (IN, OUT)

    def on_message(self, topic: str, message: Payload) -> None:
        raise ZeroDivisionError


def test_a_node_that_fails_starves_no_other_and_its_fault_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    graph, tapped = Graph(), list[Payload]()
    for make in (Faulty, Doubler, Listener):
        graph.add(make)
    graph.tap("in", lambda _topic, message: tapped.append(message))
    for number in (1.0, 2.0):
        with pytest.raises(PPaaSError, match="internal error: ZeroDivisionError"):
            graph.inject("in", std_msgs.Float64(number))
    assert [value for topic, value in graph.nodes["listener"].heard if topic == "out"] == [2.0, 4.0]  # type: ignore[attr-defined]
    assert tapped == [std_msgs.Float64(1.0), std_msgs.Float64(2.0)]
    failed = [record.getMessage() for record in caplog.records if record.levelname == "ERROR"]
    assert failed == [f"node 'faulty' on topic {topic!r} failed; the other listeners go on" for topic in ("in", "out")]


class Refusing(Node):
    """Refuses each message, for a reason that the message names."""

    name = "refusing"
    subscribes = (OUT,)

    def on_message(self, topic: str, message: Payload) -> None:
        assert isinstance(message, std_msgs.Float64)
        raise (InvalidInput("a"), NotFound("b", "c"), Conflict("d"))[int(message.data / 2.0)]


def test_each_kind_of_refusal_is_a_warning_once_while_it_is_remembered(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(topic_bus, "MOST_REFUSALS", 2)
    graph = Graph()
    graph.add(Doubler)
    graph.add(Refusing)

    def warned(*kinds: int) -> list[bool]:
        caplog.clear()
        for kind in kinds:
            graph.inject("in", std_msgs.Float64(float(kind)))
        return [record.levelname == "WARNING" for record in caplog.records if "is refused" in record.getMessage()]

    with caplog.at_level(logging.DEBUG):
        assert warned(0, 0, 1, 0, 1) == [True, False, True, False, False]
        assert warned(2, 2, 1, 0) == [True, False, False, True], "the kind that was longest ago was forgotten"


def test_taps_and_watches_that_fail_reach_neither_nodes_nor_senders() -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError

    graph, heard = Graph(), list[object]()
    doubler = graph.add(Doubler)
    for topic in ("in", "out"):
        graph.tap(topic, fail)
        graph.tap(topic, lambda topic, _message: heard.append(topic))
    graph.tap_published(fail)
    graph.tap_published(lambda topic, _message: heard.append(f"all: {topic}"))
    graph.watch(fail)
    graph.watch(lambda _node, name, _topic: heard.append(f"watch: {name}"))
    graph.inject("in", std_msgs.Float64(1.0))
    assert heard == ["all: out", "out", "all: last", "in"]
    doubler.context.declare(doubler, Topic("more", std_msgs.Float64))
    doubler.context.undeclare(doubler, "more")
    assert heard[4:] == ["watch: more", "watch: more"]


def test_a_caller_that_fails_does_not_keep_others_from_the_end_of_a_node() -> None:
    class Waiting(Node):
        name = "waiting"
        services = (Service("wait", std_srvs.EmptyService),)

        def on_call(self, service: str, request: Message, reply: Reply) -> None:
            """Never answer."""

    def fail(_: object) -> None:
        raise ZeroDivisionError

    graph, ended = Graph(), list[object]()
    graph.add(Waiting)
    graph.call("wait", std_msgs.Empty(), fail)
    graph.call("wait", std_msgs.Empty(), ended.append)
    graph.remove("waiting")
    assert [type(error).__name__ for error in ended] == ["Unavailable"]


def test_a_gate_replaces_the_messages_of_nodes_and_of_clients_for_all_that_hear_them():
    graph = Graph()
    doubler, heard, published = graph.add(Doubler), [], []
    graph.tap("out", lambda _, message: heard.append(message.data))
    graph.tap_published(lambda topic, message: published.append((topic, message.data)))
    graph.gate("out", lambda message: std_msgs.Float64(-message.data))
    graph.inject("in", std_msgs.Float64(1.0))
    graph.inject("out", std_msgs.Float64(5.0))
    assert (doubler.last, heard) == (2.0, [-2.0, -5.0])
    assert published == [("out", -2.0), ("last", 2.0)]
