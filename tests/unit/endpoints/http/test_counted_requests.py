"""Requests are counted by the class of their status and the time until their answer begins."""

import pytest
from starlette.types import Message, Receive, Scope, Send

from endpoints.http.counted_requests import CountedRequests
from engine.control.counts import REQUEST_SECONDS
from ppaas.clock import ManualClock


async def nothing() -> Message:
    return {"type": "http.disconnect"}


async def serve(
    *statuses: int, kind: str = "http", took: float = 0.0, fault: Exception | None = None
) -> CountedRequests:
    """Serve a request for each status, as an application that takes some time, and raises an error in the end."""
    clock, sent = ManualClock(100.0), list[Message]()

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        clock.advance(took)
        if "status" in scope:
            await send({"type": f"{kind}.response.start", "status": scope["status"]})
            clock.advance(60.0)
            await send({"type": f"{kind}.response.body"})
        if fault is not None:
            raise fault

    async def send(message: Message) -> None:
        sent.append(message)

    counted = CountedRequests(app, clock)
    for status in statuses:
        scope: Scope = {"type": kind} | ({"status": status} if status else {})
        if fault is None:
            await counted(scope, nothing, send)
        else:
            with pytest.raises(type(fault)):
                await counted(scope, nothing, send)
    assert len(sent) == 2 * sum(status > 0 for status in statuses), "all messages are passed on"
    return counted


async def test_answers_are_counted_by_the_class_of_their_status() -> None:
    counts = (await serve(200, 204, 304, 404, 422, 503)).counts()
    assert counts.statuses == (0, 2, 1, 2, 1)
    assert sum(counts.seconds) == 6


async def test_the_time_ends_where_the_answer_begins() -> None:
    counts = (await serve(200, took=0.25)).counts()
    assert counts.total == 0.25
    assert counts.seconds.index(1) == REQUEST_SECONDS.index(0.5)


@pytest.mark.parametrize("status", [0, 200])
async def test_a_request_is_counted_once_when_its_application_fails(status: int) -> None:
    counts = (await serve(status, fault=RuntimeError("a fault"))).counts()
    assert sum(counts.statuses) == sum(counts.seconds) == 1
    assert counts.statuses[4] == (status == 0)


async def test_sockets_are_not_counted() -> None:
    assert sum((await serve(101, kind="websocket")).counts().seconds) == 0
