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


async def test_blocks_are_taken_in_their_order_off_the_loop() -> None:
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


async def test_more_comes_while_a_thread_is_busy_but_not_more_than_fits() -> None:
    asked = 0
    full = threading.Event()
    seen = []

    async def counted() -> AsyncIterator[bytes]:
        nonlocal asked
        for _ in range(100):
            asked += 1
            if asked * BLOCK >= MAX_WAITING:
                full.set()
            await asyncio.sleep(0)
            yield bytes(BLOCK)

    def take(_block: bytes) -> None:
        assert full.wait(10), "nothing more was read while the thread was busy"
        seen.append(asked)

    await consume(counted(), take)
    assert len(seen) == 100
    most_ahead = max(read - place for place, read in enumerate(seen))
    assert most_ahead <= 2 * MAX_WAITING // BLOCK + 1


async def test_what_the_thread_raises_ends_it() -> None:
    def take(block: bytes) -> None:
        if block == b"bad":
            raise ValueError("bad block")

    with pytest.raises(ValueError, match="bad block"):
        await consume(stream([bytes(MAX_WAITING), b"bad"]), take)
    with pytest.raises(ValueError, match="bad block"):
        await consume(stream([b"bad", bytes(MAX_WAITING), bytes(MAX_WAITING), bytes(MAX_WAITING)]), take)


@pytest.mark.parametrize("cancel", [False, True])
async def test_no_thread_takes_anything_once_it_has_ended(cancel: bool) -> None:
    began, go_on = threading.Event(), threading.Event()
    taking: list[str] = []

    def take(_block: bytes) -> None:
        taking.append("began")
        began.set()
        assert go_on.wait(10)
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
    go_on.set()
    with pytest.raises(asyncio.CancelledError if cancel else ConnectionError):
        await task
    assert taking == ["began", "ended"]
