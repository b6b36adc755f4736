"""Items from Zenoh's threads, and requests that arrive twice."""

import asyncio
import threading

import pytest

from engine.fabric.inbox import BATCH, MARGIN, Inbox, RequestCache
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable


async def drain() -> None:
    for _ in range(1000):
        await asyncio.sleep(0)


async def test_items_from_other_threads_arrive_on_the_loop_in_order():
    taken, threads = [], set()

    def take(item: int) -> None:
        taken.append(item)
        threads.add(threading.current_thread())

    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), take, 1000)
    await asyncio.to_thread(lambda: [inbox.put(i) for i in range(500)])
    await drain()
    assert taken == list(range(500))
    assert threads == {threading.main_thread()}


async def test_the_newest_items_are_kept_when_the_loop_is_slow():
    taken: list[int] = []
    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), taken.append, 10)
    for i in range(1000):
        inbox.put(i)
    await drain()
    assert taken == list(range(990, 1000))


async def test_many_items_do_not_block_the_loop():
    taken: list[int] = []
    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), taken.append, 10 * BATCH)
    for i in range(10 * BATCH):
        inbox.put(i)
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert 0 < len(taken) < 10 * BATCH
    await drain()
    assert len(taken) == 10 * BATCH


async def test_failing_callback_does_not_stop_delivery(caplog):
    taken = []

    def take(item: int) -> None:
        taken.append(item)
        if item == 1:
            raise ValueError("one")

    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), take, 10)
    for i in range(3):
        inbox.put(i)
    await drain()
    assert taken == [0, 1, 2]
    assert "a callback of the fabric raised an exception" in caplog.text


async def test_closed_inbox_delivers_nothing():
    taken: list[int] = []
    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), taken.append, 10)
    inbox.put(1)  # wakes the loop
    inbox.close()
    inbox.put(2)
    await drain()
    assert taken == []


def test_put_on_a_closed_loop_does_nothing():
    loop = asyncio.new_event_loop()
    inbox: Inbox[int] = Inbox(loop, print, 10)
    loop.close()
    inbox.put(1)


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
