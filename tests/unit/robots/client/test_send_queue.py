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


async def test_frames_leave_in_the_order_in_which_they_came() -> None:
    outbox = SendQueue()
    for frame in "abc":
        await outbox.put(frame)
    assert await drain(outbox) == ["a", "b", "c"]


async def test_the_newest_takes_the_place_of_the_older_of_its_key_alone() -> None:
    outbox = SendQueue()
    outbox.put_newest("scan", "scan 1")
    await outbox.put("odom 1")
    outbox.put_newest("depth", "depth 1")
    outbox.put_newest("scan", "scan 2")
    assert await drain(outbox) == ["scan 2", "odom 1", "depth 1"]
    assert outbox.dropped == 1


async def test_a_frame_being_sent_is_not_replaced_under_the_sender() -> None:
    outbox = SendQueue()
    outbox.put_newest("scan", "scan 1")
    assert await outbox.next() == "scan 1"
    outbox.put_newest("scan", "scan 2")
    outbox.sent()
    assert await drain(outbox) == ["scan 2"]
    assert outbox.dropped == 0


async def test_a_full_send_queue_drops_the_newest_only_and_lets_the_others_wait() -> None:
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


async def test_of_what_was_sent_the_cloud_gets_again_what_it_did_not_take_in_order_and_first() -> None:
    outbox = SendQueue()
    for frame in "abcd":
        await outbox.put(frame)
    await send(outbox, 3)
    outbox.resume(taken=1)
    assert await drain(outbox) == ["b", "c", "d"]
    outbox.resume(taken=4)
    assert await drain(outbox) == []


async def test_a_newest_only_frame_counts_and_is_not_sent_again() -> None:
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
async def test_a_frame_whose_sending_broke_off_is_sent_again_only_if_it_did_not_arrive(
    taken: int, left: list[str]
) -> None:
    outbox = SendQueue()
    for frame in "abc":
        await outbox.put(frame)
    await send(outbox, 1)
    assert await outbox.next() == "b"
    outbox.resume(taken)
    assert await drain(outbox) == left


async def test_a_session_that_begins_anew_begins_with_its_greeting_and_makes_no_call_twice() -> None:
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


async def test_what_nobody_waits_for_any_more_is_discarded() -> None:
    outbox = SendQueue()
    await outbox.put("call 1", "call:1")
    await outbox.put("call 2", "call:2")
    outbox.discard("call:1")
    assert await drain(outbox) == ["call 2"]


async def test_closing_wakes_all_who_wait_with_the_reason() -> None:
    outbox = SendQueue(capacity=1)
    await outbox.put("a")
    waiting = [asyncio.create_task(outbox.put("b")), asyncio.create_task(outbox.drained())]
    await asyncio.sleep(0)
    outbox.close(Unavailable("gone"))
    for task in waiting:
        with pytest.raises(Unavailable, match="gone"):
            await task


def test_an_send_queue_without_capacity_is_refused() -> None:
    with pytest.raises(ValueError, match="must be 1 or more"):
        SendQueue(0)
