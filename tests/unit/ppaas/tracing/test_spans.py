"""Spans: parts of traces, their errors, sampling, and work in other threads."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import NotFound, PlanCancelled
from ppaas.tracing.context import current
from ppaas.tracing.spans import (
    LONGEST,
    NOTHING,
    Sampling,
    SpanRecord,
    carried,
    entry,
    own_sampling,
    record_spans,
    served,
    span,
    traced,
    traceparent,
    within,
)

TRACE, CLIENT = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"
PARENT = f"00-{TRACE}-{CLIENT}-01"
UNSAMPLED = f"00-{TRACE}-{CLIENT}-00"


class Shelf:
    """Object whose calls are traced."""

    size = 3

    def find(self, name: str, *, most: int = 1) -> str:
        """Return a name so often."""
        return name * most

    def lose(self) -> None:
        """Fail."""
        raise NotFound("book", "Moby Dick")


def test_nothing_is_recorded_unless_it_is_switched_on() -> None:
    shelf = Shelf()
    with entry("request", PARENT), within(PARENT), span("part"), served("call", PARENT):
        assert current.get() is None
        assert (traceparent(), own_sampling()) == ("", None)
        assert carried(shelf.find) == shelf.find
    assert (entry("request", PARENT), span("part"), traced(shelf, "shelf")) == (NOTHING, NOTHING, shelf)


def test_parts_belong_to_the_request_of_the_client(recorded: list[SpanRecord]) -> None:
    with entry("request", PARENT, {"size": 3}) as request, span("part", {"text": "x" * 1000}, "client"):
        request.set({"status": 200})
        assert traceparent().startswith(f"00-{TRACE}-")
    assert current.get() is None
    part, whole = recorded
    assert {part.trace, whole.trace} == {TRACE}
    assert (whole.parent, part.parent) == (CLIENT, whole.id)
    assert (whole.name, whole.kind, whole.attributes) == ("request", "server", {"size": 3, "status": 200})
    assert (part.kind, part.attributes) == ("client", {"text": "x" * LONGEST})
    assert whole.began <= part.began <= part.ended <= whole.ended


def test_a_request_without_a_trace_begins_one(recorded: list[SpanRecord]) -> None:
    for _ in range(2):
        with entry("request", "not a trace"):
            assert traceparent()
    first, second = recorded
    assert first.trace != second.trace
    assert first.parent == second.parent == ""


def test_work_for_no_trace_has_no_spans(recorded: list[SpanRecord]) -> None:
    with span("heartbeat"), served("call", ""), within(""):
        assert traceparent() == ""
    assert not recorded


def test_an_error_is_recorded_and_goes_on(recorded: list[SpanRecord]) -> None:
    with pytest.raises(NotFound), entry("request", ""):
        raise NotFound("map", "attic")
    with pytest.raises(ZeroDivisionError), entry("request", ""):
        _ = 1 // 0
    found, internal = recorded
    assert (found.error, "attic" in found.message) == ("not-found", True)
    assert internal.error == "ZeroDivisionError"


@pytest.mark.parametrize("error", [PlanCancelled("elsewhere"), asyncio.CancelledError()])
def test_work_that_was_cancelled_has_not_failed(recorded: list[SpanRecord], error: BaseException) -> None:
    with pytest.raises(type(error)), entry("request", ""):
        raise error
    [cancelled] = recorded
    assert (cancelled.error, cancelled.attributes) == ("", {"ppaas.cancelled": True})


def test_a_span_without_a_block_ends_once(recorded: list[SpanRecord]) -> None:
    goal = entry("goal", PARENT)
    with goal.active(), span("plan"):
        pass
    assert current.get() is None
    goal.fail("aborted", "the robot is stuck")
    goal.end()
    goal.end(NotFound("robot", "tb1"))
    plan, ended = recorded
    assert (plan.parent, ended.error, ended.message) == (ended.id, "aborted", "the robot is stuck")


def test_what_a_client_does_not_want_is_not_recorded_and_stays_so(recorded: list[SpanRecord]) -> None:
    with entry("request", UNSAMPLED), span("part"):
        assert traceparent() == UNSAMPLED
        with served("call", traceparent()), within(traceparent()), span("further part"):
            assert traceparent() == UNSAMPLED
            with entry("goal", traceparent()):
                pass
    assert not recorded


def test_a_ratio_of_the_traces_is_recorded() -> None:
    spans = list[SpanRecord]()
    record_spans(spans.append, Sampling(0.25))
    for _ in range(400):
        with entry("request", ""), span("part"):
            pass
    with entry("of a client", PARENT):
        pass
    record_spans(None)
    assert spans.pop().name == "of a client"
    assert 100 < len(spans) < 300
    assert len(spans) == 2 * len({each.trace for each in spans})


@pytest.mark.parametrize(("sampling", "sampled"), [(Sampling(1.0, False), True), (Sampling(0.0, False), False)])
def test_a_sampler_that_does_not_follow_the_client_decides(sampling: Sampling, sampled: bool) -> None:
    spans = list[SpanRecord]()
    record_spans(spans.append, sampling)
    for parent in (PARENT, UNSAMPLED):
        with entry("request", parent):
            pass
    record_spans(None)
    assert len(spans) == 2 * sampled


def test_work_in_another_thread_belongs_to_the_trace(recorded: list[SpanRecord]) -> None:
    def plan() -> None:
        with span("plan"):
            pass

    with ThreadPoolExecutor(1) as threads, entry("request", PARENT):
        threads.submit(plan).result()  # of no trace
        threads.submit(carried(plan)).result()
        assert threads.submit(current.get).result() is None
    plan_span, request = recorded
    assert (plan_span.name, plan_span.parent) == ("plan", request.id)


def test_calls_of_a_store_are_spans_while_they_work_for_a_trace(recorded: list[SpanRecord]) -> None:
    shelf = traced(Shelf(), "shelf")
    assert (shelf.size, shelf.find("a")) == (3, "a")
    assert not recorded
    with entry("request", PARENT):
        assert shelf.find("b", most=2) == "bb"
        with pytest.raises(NotFound):
            shelf.lose()
    found, lost, _ = recorded
    assert (found.name, found.kind, found.error) == ("shelf find", "client", "")
    assert (lost.name, lost.error) == ("shelf lose", "not-found")
