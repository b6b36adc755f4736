import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.geometry import Pose2D
from robots.sim.simulator import BURST, Simulator
from robots.sim.world import World
from tests.support.waiting import patience
from tests.support.world.rooms import room


def simulated(dt: float = 0.02) -> tuple[World, Simulator, ManualClock]:
    clock = ManualClock(5000.0)
    world = World(room(4.0, 4.0), dt=dt)
    world.add_robot(Pose2D(2.0, 2.0))
    return world, Simulator(world, clock, ManualClock(1e9)), clock


@given(st.lists(st.floats(0.0, 0.4), max_size=30))
def test_the_simulation_is_at_most_one_step_behind_and_never_ahead(waits: list[float]) -> None:
    world, simulator, clock = simulated()
    for wait in waits:
        clock.advance(wait)
        simulator.catch_up()
        behind = (clock() - 5000.0) - world.time()
        assert -1e-6 < behind < world.dt + 1e-6


def test_a_delayed_world_catches_up_in_bursts() -> None:
    world, simulator, clock = simulated()
    clock.advance(1.0)
    assert simulator.catch_up() == BURST
    while simulator.due():
        simulator.catch_up()
    assert world.time() == pytest.approx(1.0, abs=world.dt)


def test_stamps_follow_the_wall_clock() -> None:
    world, simulator, clock = simulated()
    clock.advance(0.1)
    simulator.catch_up()
    assert world.stamp() == pytest.approx(1e9 + 0.1, abs=world.dt)


async def test_the_simulator_runs_until_it_is_cancelled() -> None:
    world = World(room(4.0, 4.0))
    running = asyncio.create_task(Simulator(world).run())
    async with patience(20):
        while world.time() < 0.2:
            await asyncio.sleep(0.005)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    stopped = world.steps
    await asyncio.sleep(0.05)
    assert world.steps == stopped
