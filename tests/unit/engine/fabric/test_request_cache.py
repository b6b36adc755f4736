import asyncio

import pytest

from engine.fabric.inbox import MARGIN, RequestCache
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable


class Server:
    """Counts executed requests."""

    def __init__(self):
        self.done = []
        self.go = asyncio.Event()

    async def work(self, name: str) -> bytes:
        await self.go.wait()
        self.done.append(name)
        return name.encode()


async def test_a_request_that_arrives_twice_is_executed_once():
    server, answers = Server(), RequestCache()
    first = answers.answer("1", 5.0, lambda: server.work("a"))
    second = answers.answer("1", 5.0, lambda: server.work("a"))
    server.go.set()
    assert await first == await second == b"a"
    assert await answers.answer("1", 5.0, lambda: server.work("a")) == b"a"
    assert server.done == ["a"]


async def test_error_is_cached_as_an_answer():
    tries = []

    async def fail() -> bytes:
        tries.append(1)
        raise Unavailable("no room")

    answers = RequestCache()
    for _ in range(2):
        with pytest.raises(Unavailable, match="no room"):
            await answers.answer("1", 5.0, fail)
    assert len(tries) == 1


async def test_an_answer_is_kept_while_its_request_may_be_repeated():
    clock = ManualClock()
    server, answers = Server(), RequestCache(clock=clock)
    server.go.set()
    await answers.answer("1", 5.0, lambda: server.work("a"))
    clock.advance(5.0 + MARGIN - 0.1)
    await answers.answer("1", 5.0, lambda: server.work("a"))
    assert server.done == ["a"]
    clock.advance(2.0)
    await answers.answer("2", 5.0, lambda: server.work("b"))
    assert len(answers) == 1


async def test_an_executing_request_is_never_forgotten():
    clock = ManualClock()
    server, answers = Server(), RequestCache(clock=clock)
    first = answers.answer("1", 1.0, lambda: server.work("a"))
    clock.advance(1000.0)
    answers.answer("2", 1.0, lambda: server.work("b"))
    assert answers.answer("1", 1.0, lambda: server.work("a")) is first
    answers.cancel()


async def test_a_full_cache_refuses_new_requests_and_answers_old_ones():
    server, answers = Server(), RequestCache(limit=2)
    server.go.set()
    await answers.answer("1", 5.0, lambda: server.work("a"))
    await answers.answer("2", 5.0, lambda: server.work("b"))
    with pytest.raises(Unavailable, match="2 requests"):
        answers.answer("3", 5.0, lambda: server.work("c"))
    assert await answers.answer("1", 5.0, lambda: server.work("a")) == b"a"
    assert server.done == ["a", "b"]


async def test_cancel_stops_all_requests():
    server, answers = Server(), RequestCache()
    task = answers.answer("1", 5.0, lambda: server.work("a"))
    answers.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert server.done == [] and len(answers) == 0
