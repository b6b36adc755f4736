"""Export of spans to a real receiver, and to ones that are away, refuse or are slow."""

import logging
import socket
from contextlib import closing

import pytest

from engine.tracing.export import MOST, SpanExport
from ppaas.tracing.spans import SpanRecord
from tests.support.network.trace_receiver import trace_receiver
from tests.support.waiting import until

TRACE, SPAN, PARENT = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331", "00f067aa0ba902b7"
ATTRIBUTES = {"ppaas.planner": "navfn", "n": 3, "ok": True}


def record(name: str = "plan", error: str = "", message: str = "") -> SpanRecord:
    return SpanRecord(name, "server", TRACE, SPAN, PARENT, 1000.25, 1000.5, dict(ATTRIBUTES), error, message)


async def test_a_span_arrives_as_it_was(caplog: pytest.LogCaptureFixture) -> None:
    with trace_receiver() as receiver:
        export = SpanExport(receiver.url)
        export.add(record(), "ppaas-endpoint", "endpoint-1")
        export.add(record("goal", "no-path", "a wall"), "ppaas-container", "c1")
        export.close()
        await until(lambda: len(receiver.spans) == 2)
    plan, goal = sorted(receiver.spans, key=lambda span: span.name, reverse=True)
    assert (plan.service, plan.process) == ("ppaas-endpoint", "endpoint-1")
    assert (plan.name, plan.trace, plan.id, plan.parent) == ("plan", TRACE, SPAN, PARENT)
    assert (plan.began, plan.ended, plan.failed) == (1000_250_000_000, 1000_500_000_000, False)
    assert plan.attributes == ATTRIBUTES
    assert (goal.failed, goal.attributes["error.type"]) == (True, "no-path")
    assert goal.events == (("exception", {"exception.type": "no-path", "exception.message": "a wall"}),)
    assert (export.dropped, caplog.records) == (0, [])


async def test_spans_are_dropped_and_counted_while_the_receiver_refuses(caplog: pytest.LogCaptureFixture) -> None:
    with trace_receiver() as receiver, caplog.at_level(logging.INFO):
        receiver.status = 400
        export = SpanExport(f"{receiver.url}/")
        export.add(record(), "ppaas-endpoint", "endpoint-1")
        await until(lambda: export.dropped == 1)
        receiver.status = 200
        export.add(record(), "ppaas-endpoint", "endpoint-1")
        await until(lambda: len(receiver.spans) == 1)
        export.close()
    dropped, over = (line.getMessage() for line in caplog.records)
    assert dropped.startswith(f"spans of traces are dropped, 1 since the start: {receiver.url}/v1/traces")
    assert "takes spans again" in over


async def test_nothing_waits_for_a_receiver_that_is_silent(caplog: pytest.LogCaptureFixture) -> None:
    with closing(socket.create_server(("127.0.0.1", 0))) as silent:
        export = SpanExport(f"http://127.0.0.1:{silent.getsockname()[1]}")
        for _ in range(2 * MOST):
            export.add(record(), "ppaas-endpoint", "endpoint-1")
        assert export.dropped >= 1
        export.close()
    assert "spans of traces are dropped" in caplog.text


async def test_a_receiver_that_is_away_is_reported_with_the_reason(caplog: pytest.LogCaptureFixture) -> None:
    with closing(socket.create_server(("127.0.0.1", 0))) as server:
        url = f"http://127.0.0.1:{server.getsockname()[1]}"
    export = SpanExport(url)
    export.add(record(), "ppaas-endpoint", "endpoint-1")
    await until(lambda: export.reasons.last)
    export.close()
    await until(lambda: export.dropped == 1)
    assert url in caplog.text
    assert "refused" in caplog.text
