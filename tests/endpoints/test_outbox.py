"""What waits for one client is bounded, in order, and never an old command."""

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from endpoints.outbox import EXPIRY, MAX_KEEP, Outbox
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable


async def drain(outbox: Outbox) -> list[str]:
    frames = []
    try:
        while True:
            async with asyncio.timeout(0.01):
                frames.append(await outbox.get())
    except TimeoutError:
        return frames


async def test_of_a_command_only_the_newest_is_kept_and_it_expires() -> None:
    clock = ManualClock()
    outbox = Outbox(clock)
    outbox.put("cmd_vel", "old", keep=1)
    outbox.put("cmd_vel", "new", keep=1)
    assert await drain(outbox) == ["new"]
    outbox.put("cmd_vel", "stale", keep=1)
    clock.advance(EXPIRY["cmd_vel"])
    assert await drain(outbox) == []


async def test_answers_are_never_dropped_but_a_client_that_reads_none_is() -> None:
    outbox = Outbox()
    for number in range(10 * MAX_KEEP):
        outbox.put_answer(str(number))
    with pytest.raises(Unavailable):
        outbox.put_answer("one too many")


def test_what_was_dropped_for_a_client_that_does_not_read_takes_no_room_and_is_no_answer() -> None:
    outbox = Outbox()
    for number in range(100 * MAX_KEEP):
        outbox.put("cmd_vel", str(number), keep=1)
    assert len(outbox) == 1
    outbox.put_answer("still served")
    assert len(outbox) == 2


async def test_get_waits_for_the_next_frame() -> None:
    outbox = Outbox()
    waiting = asyncio.create_task(outbox.get())
    await asyncio.sleep(0)
    assert not waiting.done()
    outbox.put("a", "x", keep=1)
    assert await waiting == "x"


@given(st.lists(st.tuples(st.sampled_from("abc"), st.integers(1, 4)), max_size=60))
def test_each_topic_keeps_its_newest_in_order(puts: list[tuple[str, int]]) -> None:
    keep = {"a": 1, "b": 2, "c": 5}

    async def check() -> list[str]:
        outbox = Outbox(ManualClock())
        for number, (topic, _) in enumerate(puts):
            outbox.put(topic, f"{topic}{number}", keep[topic])
        return await drain(outbox)

    frames = asyncio.run(check())
    for topic, length in keep.items():
        sent = [f"{topic}{number}" for number, (name, _) in enumerate(puts) if name == topic]
        assert [frame for frame in frames if frame[0] == topic] == sent[-length:]
    numbers = [int(frame[1:]) for frame in frames]
    assert numbers == sorted(numbers)
