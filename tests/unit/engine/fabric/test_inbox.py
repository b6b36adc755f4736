import asyncio
import threading

from engine.fabric.inbox import BATCH, Inbox


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
