import asyncio
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from robots.sim.drivetrain import Drivetrain, DrivetrainModel
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


DT = 0.01


def driven(model: DrivetrainModel, seconds: float) -> list[Velocity]:
    drive = Drivetrain(model, np.random.default_rng(0))
    drive.command(Velocity(1.0, 1.0))
    return [drive.turn(DT) for _ in range(round(seconds / DT))]


def test_acceleration_and_speed_are_limited() -> None:
    speeds = driven(DrivetrainModel(0.5, 0.8, 1.0, 2.0), 1.0)
    assert np.abs(np.diff([(0.0, 0.0), *speeds], axis=0)).max(axis=0) == pytest.approx((0.01, 0.02))
    assert speeds[-1] == pytest.approx((0.5, 0.8))


def test_commands_are_delayed_and_motors_lag() -> None:
    speeds = driven(DrivetrainModel(2.0, 2.0, 1e3, 1e3, lag=0.1, delay=0.2), 1.0)
    assert all(speed == (0.0, 0.0) for speed in speeds[:20])
    assert speeds[20].linear > 0.0
    assert speeds[29].linear == pytest.approx(1.0 - math.exp(-1.0), abs=1e-6)


def test_commands_are_applied_in_order() -> None:
    drive = Drivetrain(DrivetrainModel(2.0, 2.0, 1e3, 1e3, delay=0.05), np.random.default_rng(0))
    speeds = []
    for step in range(20):
        drive.command(Velocity(float(step) / 10.0, 0.0))
        speeds.append(drive.turn(DT).linear)
    assert speeds[:5] == [0.0] * 5
    assert speeds[5:] == pytest.approx([step / 10.0 for step in range(15)])


def test_wheels_slip_as_configured_without_an_effect_on_odometry() -> None:
    model = DrivetrainModel(2.0, 2.0, 1e3, 1e3, slip_linear=0.05, slip_angular=0.15, slip_time=0.02)
    speeds = np.array(driven(model, 100.0))
    assert speeds.std(axis=0) == pytest.approx((0.05, 0.15), rel=0.1)
    drive = Drivetrain(model, np.random.default_rng(0))
    drive.command(Velocity(1.0, 1.0))
    drive.turn(DT)
    assert drive.wheels == (1.0, 1.0)
