"""The contract of every local planner."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from benchmarks.navigation.heavy_bases import HeavyBase, stop
from ppaas.controllers.base import Controller, ControlRequest, Velocity
from ppaas.controllers.registry import controller_names, create
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from tests.support.world import driving, worlds
from tests.support.world.driving import OPEN, RADIUS, Drive, Unicycle, World, along_x, assert_arrived, drive

PASSAGE = "####################\n....................\n####################"

Make = Callable[..., Controller]


@pytest.fixture(params=controller_names())
def made(request: pytest.FixtureRequest) -> Make:
    """Return a function that creates the local planner with given parameters."""

    def make(**parameters: Any) -> Controller:
        return create(request.param, **{"robot_radius": RADIUS, **parameters})

    return make


def travel(controller: Controller, world: World, start: Pose2D, goal: Pose2D) -> Drive:
    return driving.travel(controller, world, start, goal, 60.0, 0.1)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("draw", [worlds.rooms, worlds.pillars])
def test_controller_reaches_the_goal_without_a_collision(made: Make, draw: Callable[[int], World], seed: int) -> None:
    world = draw(seed)
    start, goal, plan = worlds.journey(world, seed)
    controller = made()
    controller.set_plan(plan.poses)
    result = drive(world, Unicycle(start), controller, 20.0 + 10.0 * plan.length)
    assert_arrived(result, goal)
    assert result.travelled <= 1.2 * plan.length + 0.3


@pytest.mark.parametrize(("period", "parameters"), [(0.05, {}), (0.1, {"max_vel_x": 1.0}), (0.2, {"acc_lim_x": 0.4})])
def test_controller_reaches_the_goal_at_other_rates_and_limits(
    made: Make, period: float, parameters: dict[str, float]
) -> None:
    world = worlds.rooms(104)
    start, goal, plan = worlds.journey(world, 4)
    controller = made(**parameters)
    controller.set_plan(plan.poses)
    assert_arrived(drive(world, Unicycle(start), controller, 20.0 + 10.0 * plan.length, period), goal)


@pytest.mark.parametrize("base", [HeavyBase(1.0, 0.15), HeavyBase(1.5, 0.5)])
def test_a_base_with_slow_brakes_stops_at_the_goal(made: Make, base: HeavyBase, request: pytest.FixtureRequest) -> None:
    """It stops from its fastest speed in more than two metres, farther than any rollout looks."""
    ended = stop(request.node.callspec.params["made"], base)
    assert ended.arrived
    assert ended.past <= 0.05


def test_commands_respect_the_limits_of_speed_and_acceleration(made: Make) -> None:
    result = travel(made(), worlds.picture(OPEN), Pose2D(0.8, 1.0, 2.0), Pose2D(3.2, 1.4, -1.0))
    assert result.reached
    commands = np.array([(0.0, 0.0), *result.commands])
    steps = np.abs(np.diff(commands, axis=0))
    assert steps[:, 0].max() <= 0.1 + 1e-9
    assert steps[:, 1].max() <= max(0.3, 2 * 0.2) + 1e-9
    assert 0.3 < commands[:, 0].max() <= 0.5
    assert commands[:, 0].min() >= 0.0
    assert np.abs(commands[:, 1]).max() <= 1.5


def test_controller_slows_down_in_a_narrow_passage(made: Make) -> None:
    seconds = []
    for scale in (11, 22):
        y = 0.075 * scale
        seconds.append(travel(made(), worlds.picture(PASSAGE, scale), Pose2D(1.0, y), Pose2D(5.0, y)).seconds)
    assert seconds[0] > 1.15 * seconds[1]


def test_a_robot_in_an_inscribed_cell_drives_out(made: Make) -> None:
    world = worlds.picture(OPEN)
    start = Pose2D(0.4 + RADIUS + 0.01, 1.2, 0.3)
    assert world.costmap.data[world.costmap.info.cell_of(start.x, start.y)] == 253
    assert_arrived(travel(made(), world, start, Pose2D(2.5, 1.2)), Pose2D(2.5, 1.2))


@pytest.mark.parametrize(
    ("pose", "velocity", "period"),
    [
        (Pose2D(math.nan, 1.0), Velocity(), 0.1),
        (Pose2D(0.5, 1.0), Velocity(math.inf, 0.0), 0.1),
        (Pose2D(0.5, 1.0), Velocity(), 0.0),
        (Pose2D(0.5, 1.0), Velocity(), math.nan),
    ],
)
def test_non_finite_requests_are_refused(made: Make, pose: Pose2D, velocity: Velocity, period: float) -> None:
    controller = made()
    controller.set_plan(along_x(0.5, 2.0))
    with pytest.raises(InvalidInput):
        controller.compute_velocity(ControlRequest(pose, velocity, worlds.picture(OPEN).costmap, period))


def test_a_missing_plan_is_reported(made: Make) -> None:
    with pytest.raises(InvalidInput, match="set_plan"):
        made().is_goal_reached(Pose2D(0.0, 0.0), Velocity())
