"""Idle clients are disconnected, unless their robot has a goal."""

import asyncio

import pytest

from engine.control.robot_sessions import IdleWatch
from engine.links.place_link import PlaceLink
from engine.protocols.robot_link import ContainerBeat
from ppaas.clock import ManualClock
from ppaas.errors import PPaaSError
from tests.support.waiting import until

IDLE = 100.0


class Robots:
    """Places that have clients, without a cloud."""

    def __init__(self) -> None:
        self.place = PlaceLink("robot:ann/tb1")
        self.reasons: list[PPaaSError] = []

    def held(self) -> list[PlaceLink]:
        return [] if self.reasons else [self.place]

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        assert place is self.place
        self.reasons.append(reason)

    def beat(self, *, busy: bool = False, sockets: int = 2, frames: int = 0) -> None:
        self.place.take(ContainerBeat(busy, sockets, frames))


@pytest.fixture
async def robots() -> Robots:
    return Robots()


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(0.0)


@pytest.fixture
def watch(robots: Robots, clock: ManualClock) -> IdleWatch:
    return IdleWatch(robots, IDLE, clock)  # type: ignore[arg-type]


async def test_the_place_of_idle_clients_is_closed(robots: Robots, watch: IdleWatch, clock: ManualClock) -> None:
    robots.beat()
    await watch.check()
    clock.advance(IDLE - 1.0)
    await watch.check()
    assert not robots.reasons
    clock.advance(1.0)
    await watch.check()
    [reason] = robots.reasons
    assert reason.slug == "idle"
    assert str(reason).startswith("no frames for 100 s: connect again when")


@pytest.mark.parametrize("change", [{"frames": 1}, {"sockets": 3}])
async def test_a_frame_or_a_client_at_any_endpoint_keeps_it_open(
    robots: Robots, watch: IdleWatch, clock: ManualClock, change: dict[str, int]
) -> None:
    robots.beat()
    await watch.check()
    clock.advance(IDLE - 1.0)
    robots.beat(**change)
    await watch.check()
    clock.advance(IDLE - 1.0)
    await watch.check()
    assert not robots.reasons


async def test_a_robot_with_a_goal_is_not_idle(robots: Robots, watch: IdleWatch, clock: ManualClock) -> None:
    robots.beat(busy=True)
    for _ in range(3):
        clock.advance(IDLE)
        await watch.check()
    robots.beat(busy=False)
    await watch.check()
    assert not robots.reasons, "its time begins when the goal is done"
    clock.advance(IDLE)
    await watch.check()
    assert robots.reasons


async def test_another_time_holds_at_once_and_none_disables_the_watch(robots: Robots) -> None:
    watch = IdleWatch(robots, 0.0)  # type: ignore[arg-type]
    running = asyncio.create_task(watch.run())
    robots.beat()
    await asyncio.sleep(0)
    assert len(asyncio.all_tasks()) == 2, "0 disables the watch"
    watch.change(0.01)
    await until(lambda: robots.reasons)
    assert str(robots.reasons[0]).startswith("no frames for 0.01 s")
    watch.change(0.0)
    await until(lambda: len(asyncio.all_tasks()) == 2)
    running.cancel()
