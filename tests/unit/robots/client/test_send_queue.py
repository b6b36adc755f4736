import asyncio

import pytest

from ppaas.errors import Unavailable
from robots.client.send_queue import SUBSCRIPTION, SendQueue


async def drain(outbox: SendQueue) -> list[str]:
    frames = []
    while len(outbox):
        frames.append(await outbox.next())
        outbox.sent()
    return frames


async def test_frames_are_sent_in_order() -> None:
    outbox = SendQueue()
    for frame in "abc":
        await outbox.put(frame)
    assert await drain(outbox) == ["a", "b", "c"]


async def test_a_newest_only_frame_replaces_the_older_one_of_its_key() -> None:
    outbox = SendQueue()
    outbox.put_newest("scan", "scan 1")
    await outbox.put("odom 1")
    outbox.put_newest("depth", "depth 1")
    outbox.put_newest("scan", "scan 2")
    assert await drain(outbox) == ["scan 2", "odom 1", "depth 1"]
    assert outbox.dropped == 1


async def test_a_frame_being_sent_is_not_replaced() -> None:
    outbox = SendQueue()
    outbox.put_newest("scan", "scan 1")
    assert await outbox.next() == "scan 1"
    outbox.put_newest("scan", "scan 2")
    outbox.sent()
    assert await drain(outbox) == ["scan 2"]
    assert outbox.dropped == 0


async def test_a_full_queue_drops_newest_only_frames_and_blocks_others() -> None:
    outbox = SendQueue(capacity=1)
    await outbox.put("odom 1")
    outbox.put_newest("scan", "scan 1")
    waiting = asyncio.create_task(outbox.put("odom 2"))
    await asyncio.sleep(0)
    assert not waiting.done()
    assert await outbox.next() == "odom 1"
    outbox.sent()
    await waiting
    assert await drain(outbox) == ["odom 2"]
    assert outbox.dropped == 1


async def send(outbox: SendQueue, count: int) -> list[str]:
    frames = []
    for _ in range(count):
        frames.append(await outbox.next())
        outbox.sent()
    return frames


async def test_resume_resends_frames_that_were_not_received_first() -> None:
    outbox = SendQueue()
    for frame in "abcd":
        await outbox.put(frame)
    await send(outbox, 3)
    outbox.resume(taken=1)
    assert await drain(outbox) == ["b", "c", "d"]
    outbox.resume(taken=4)
    assert await drain(outbox) == []


async def test_a_newest_only_frame_is_counted_and_not_resent() -> None:
    outbox = SendQueue()
    for frame in ("odom 1", "goal", "odom 2"):
        if frame == "goal":
            await outbox.put(frame)
        else:
            outbox.put_newest("odom", frame)
        await send(outbox, 1)
    outbox.resume(taken=1)
    assert await drain(outbox) == ["goal"]


@pytest.mark.parametrize(("taken", "left"), [(1, ["b", "c"]), (2, ["c"])], ids=["not taken", "taken"])
async def test_an_interrupted_frame_is_resent_only_if_it_was_not_received(taken: int, left: list[str]) -> None:
    outbox = SendQueue()
    for frame in "abc":
        await outbox.put(frame)
    await send(outbox, 1)
    assert await outbox.next() == "b"
    outbox.resume(taken)
    assert await drain(outbox) == left


async def test_a_new_session_starts_with_its_greeting_and_repeats_no_call() -> None:
    outbox = SendQueue()
    await outbox.put("sent")
    await outbox.put("call under way", "call:1")
    await outbox.put("subscribe", SUBSCRIPTION)
    await outbox.put("waits")
    await outbox.put("call", "call:2")
    await send(outbox, 1)
    await outbox.next()
    assert outbox.waiting() == {SUBSCRIPTION, "call:2"}
    outbox.begin(["hello"])
    assert await drain(outbox) == ["hello", "waits", "call"]


async def test_a_discarded_frame_is_not_sent() -> None:
    outbox = SendQueue()
    await outbox.put("call 1", "call:1")
    await outbox.put("call 2", "call:2")
    outbox.discard("call:1")
    assert await drain(outbox) == ["call 2"]


async def test_closing_wakes_waiting_senders_with_the_reason() -> None:
    outbox = SendQueue(capacity=1)
    await outbox.put("a")
    waiting = [asyncio.create_task(outbox.put("b")), asyncio.create_task(outbox.drained())]
    await asyncio.sleep(0)
    outbox.close(Unavailable("gone"))
    for task in waiting:
        with pytest.raises(Unavailable, match="gone"):
            await task


def test_a_queue_without_capacity_is_refused() -> None:
    with pytest.raises(ValueError, match="must be 1 or more"):
        SendQueue(0)
