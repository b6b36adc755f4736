"""Paths that an endpoint counts ahead."""

import asyncio

import pytest

from engine.endpoint.cloud import AHEAD, BUSY, KEEP, PathsAhead
from ppaas.clock import ManualClock
from ppaas.errors import QuotaExceeded


class Master:
    """Master that counts paths, as long as there are some left."""

    def __init__(self) -> None:
        self.left = 10_000
        self.calls: list[tuple[str, int, int]] = []

    async def take(self, user: str, paths: int, ahead: int) -> int:
        self.calls.append((user, paths, ahead))
        await asyncio.sleep(0)
        if paths > self.left:
            raise QuotaExceeded("too many")
        self.left -= paths
        more = min(ahead, self.left)
        self.left -= more
        return more


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture
def master() -> Master:
    return Master()


@pytest.fixture
def paths(master: Master, clock: ManualClock) -> PathsAhead:
    return PathsAhead(master.take, clock)


async def test_users_who_request_few_paths_are_counted_exactly(
    paths: PathsAhead, master: Master, clock: ManualClock
) -> None:
    for _ in range(5):
        await paths.count("ann", 2)
        clock.advance(BUSY)
    assert master.calls == [("ann", 2, 0)] * 5


async def test_the_master_is_asked_once_for_many_paths(paths: PathsAhead, master: Master) -> None:
    for _ in range(2 + 3 * (AHEAD + 1)):
        await paths.count("ann", 1)
    assert master.calls == [("ann", 1, 0), *[("ann", 1, AHEAD)] * 4]
    assert 10_000 - master.left == 1 + 4 * (AHEAD + 1)


async def test_many_clients_take_ahead_once(paths: PathsAhead, master: Master) -> None:
    await asyncio.gather(*(paths.count("ann", 1) for _ in range(20)))
    assert [ahead for *_, ahead in master.calls] == [0, AHEAD, *[0] * 18]
    assert 10_000 - master.left == 20 + AHEAD


async def test_paths_that_were_counted_ahead_are_forgotten_in_time(
    paths: PathsAhead, master: Master, clock: ManualClock
) -> None:
    for _ in range(3):
        await paths.count("ann", 1)
    clock.advance(KEEP)
    await paths.count("ann", 1)
    assert [ahead for *_, ahead in master.calls] == [0, AHEAD, 0]


async def test_a_changed_quota_is_asked_for_at_once(paths: PathsAhead, master: Master) -> None:
    for _ in range(3):
        await paths.count("ann", 1)
    paths.forget("ann")
    master.left = 0
    with pytest.raises(QuotaExceeded):
        await paths.count("ann", 1)


async def test_refused_paths_use_nothing_and_users_are_counted_alone(paths: PathsAhead, master: Master) -> None:
    for _ in range(3):
        await paths.count("ann", 1)
    master.left = 0
    with pytest.raises(QuotaExceeded):
        await paths.count("ann", AHEAD)
    await paths.count("ann", AHEAD - 1)
    with pytest.raises(QuotaExceeded):
        await paths.count("bob", 1)
