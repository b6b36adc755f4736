import asyncio
import threading
from collections.abc import AsyncIterator

import pytest

from endpoints.rest.maps.body_stream import MAX_WAITING, MIN_BATCH, consume

BLOCK = MIN_BATCH // 2


async def stream(blocks: list[bytes], *, then: Exception | None = None) -> AsyncIterator[bytes]:
    for block in blocks:
        yield block
    if then is not None:
        raise then


async def test_blocks_are_consumed_in_order_in_another_thread() -> None:
    blocks = [
        bytes([number]) * size for number, size in enumerate((1, BLOCK, BLOCK, 0, 3 * MIN_BATCH, 7, MAX_WAITING, 1))
    ]
    got: list[bytes] = []
    threads = set()

    def take(block: bytes) -> None:
        threads.add(threading.get_ident())
        got.append(block)

    await consume(stream(blocks), take)
    assert got == blocks
    assert threading.get_ident() not in threads


async def test_blocks_are_read_ahead_of_a_busy_thread_within_a_bound() -> None:
    read = 0
    ahead = threading.Event()
    seen = []

    async def counted() -> AsyncIterator[bytes]:
        nonlocal read
        for _ in range(100):
            read += 1
            if read * BLOCK >= MAX_WAITING:
                ahead.set()
            await asyncio.sleep(0)
            yield bytes(BLOCK)

    def take(_block: bytes) -> None:
        assert ahead.wait(10), "nothing more was read while the thread was busy"
        seen.append(read)

    await consume(counted(), take)
    assert len(seen) == 100
    most_ahead = max(read - place for place, read in enumerate(seen))
    assert most_ahead <= 2 * MAX_WAITING // BLOCK + 1


async def test_consume_raises_the_exception_of_its_thread() -> None:
    def take(block: bytes) -> None:
        if block == b"bad":
            raise ValueError("bad block")

    with pytest.raises(ValueError, match="bad block"):
        await consume(stream([bytes(MAX_WAITING), b"bad"]), take)
    with pytest.raises(ValueError, match="bad block"):
        await consume(stream([b"bad", bytes(MAX_WAITING), bytes(MAX_WAITING), bytes(MAX_WAITING)]), take)


@pytest.mark.parametrize("cancel", [False, True])
async def test_consume_waits_for_its_thread_on_errors_and_cancellation(cancel: bool) -> None:
    began, released = threading.Event(), threading.Event()
    taking: list[str] = []

    def take(_block: bytes) -> None:
        taking.append("began")
        began.set()
        assert released.wait(10)
        taking.append("ended")

    async def cut_short() -> AsyncIterator[bytes]:
        yield bytes(MAX_WAITING)
        await asyncio.to_thread(began.wait, 10)
        if cancel:
            await asyncio.Event().wait()
        raise ConnectionError("the client is gone")

    task = asyncio.create_task(consume(cut_short(), take))
    await asyncio.to_thread(began.wait, 10)
    await asyncio.sleep(0.05)
    if cancel:
        task.cancel()
    assert not (await asyncio.wait([task], timeout=0.05))[0], "it ended before its thread did"
    released.set()
    with pytest.raises(asyncio.CancelledError if cancel else ConnectionError):
        await task
    assert taking == ["began", "ended"]
