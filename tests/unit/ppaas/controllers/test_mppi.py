import math

import numpy as np
import pytest

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.mppi import PathIntegral
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.grid.dijkstra import Dijkstra
from tests.support.world import driving, grids, worlds
from tests.support.world.driving import (
    BOX,
    OPEN,
    RADIUS,
    STANDING,
    Drive,
    Unicycle,
    World,
    along_x,
    assert_arrived,
    drive,
    gap,
    through_gap,
)


def travel(world: World, start: Pose2D, goal: Pose2D, seconds=60.0, period=0.1, **parameters) -> Drive:
    return driving.travel(PathIntegral(robot_radius=RADIUS, **parameters), world, start, goal, seconds, period)


def test_robot_facing_away_turns_and_arrives():
    world = worlds.picture(OPEN)
    assert_arrived(travel(world, Pose2D(0.8, 1.2, math.pi), Pose2D(3.0, 1.2)), Pose2D(3.0, 1.2))


def test_robot_close_to_the_goal_turns_to_the_goal_heading():
    controller = PathIntegral(robot_radius=RADIUS, max_vel_x=0.65)
    controller.set_plan(along_x(1.0, 3.0, y=1.5))
    robot = Unicycle(Pose2D(2.93, 1.52, 0.21))
    assert_arrived(drive(World(np.zeros((60, 80), bool)), robot, controller, 5.0, 0.05), Pose2D(3.0, 1.5))


def ask(controller, costmap, pose, velocity=STANDING, period=0.1, threads=1):
    return controller.compute_velocity(ControlRequest(pose, velocity, costmap, period, threads))


def obstructed(rows):
    cells = np.zeros((61, 80), bool)
    cells[rows, 40:44] = True
    return World(cells).costmap


def test_mirrored_world_gives_the_mirrored_command():
    commands = []
    for rows, side in ((slice(24, 36), 1.0), (slice(25, 37), -1.0)):
        controller = PathIntegral(robot_radius=RADIUS)
        controller.set_plan(along_x(1.0, 3.5, y=61 * 0.025))
        pose = Pose2D(1.0, 61 * 0.025 + side * 0.05, side * 0.1)
        for _ in range(3):
            command = ask(controller, obstructed(rows), pose, Velocity(0.3, 0.0))
        commands.append((command.linear, side * command.angular))
    assert commands[0] == pytest.approx(commands[1], abs=1e-6)
    assert abs(commands[0][1]) > 0.05


def test_commands_depend_on_the_seed_but_not_on_threads():
    sent = []
    for seed, threads in ((0, 1), (0, 2), (1, 1)):
        controller = PathIntegral(robot_radius=RADIUS, seed=seed)
        controller.set_plan(along_x(1.0, 3.5, y=1.5))
        sent.append([ask(controller, obstructed(slice(24, 36)), Pose2D(1.0, 1.5), threads=threads) for _ in range(3)])
    assert sent[0] == sent[1]
    assert sent[0] != sent[2]


def test_footprint_passes_a_gap_too_narrow_for_its_disc():
    for footprint, passes in ((BOX, True), ((), False)):
        controller = PathIntegral(robot_radius=0.4, footprint=footprint)
        assert (max(through_gap(controller, gap().costmap, 60)) > 3.6) is passes


def test_commands_not_yet_executed_are_considered():
    """Of two robots at the same pose, one has already commanded a turn: it is commanded to turn less."""
    costmap = World(np.zeros((60, 80), bool)).costmap
    turns = []
    for before in (Velocity(0.3, 0.0), Velocity(0.3, 0.6)):
        controller = PathIntegral(command_delay=0.3)
        controller.set_plan(along_x(0.5, 3.5, y=1.5))
        controller._sent.extend([before] * 3)
        turns.append(ask(controller, costmap, Pose2D(1.0, 1.5), before).angular - before.angular)
    assert turns[1] < turns[0] - 0.1


def test_robot_stops_before_an_unplanned_wall():
    world = worlds.picture("####################\n....................\n####################", 16)
    blocked = world.walls.copy()
    blocked[:, 160:164] = True
    blocked = World(blocked)
    controller = PathIntegral(robot_radius=RADIUS)
    controller.set_plan(Dijkstra().plan(world.costmap, PlanRequest(Pose2D(6.0, 1.2), Pose2D(14.0, 1.2))).poses)
    result = drive(blocked, Unicycle(Pose2D(6.0, 1.2)), controller, 12.0)
    assert not result.reached
    assert result.clearance > 0.0
    assert result.stuck > 30
    with pytest.raises(NoValidControl, match="recover"):
        ask(controller, blocked.costmap, result.end)


@pytest.mark.parametrize("cost", [253, 254])
def test_no_velocity_is_valid_without_a_free_cell(cost):
    controller = PathIntegral()
    controller.set_plan(along_x(0.5, 2.0))
    with pytest.raises(NoValidControl):
        ask(controller, grids.of(np.full((60, 60), cost, np.uint8), 0.05), Pose2D(0.5, 1.2))


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1)])
def test_tiny_costmap_raises_no_other_error(shape):
    controller = PathIntegral()
    controller.set_plan(along_x(0.0, 2.0, y=0.02))
    costmap = grids.of(np.zeros(shape, np.uint8), 0.05)
    try:
        assert ask(controller, costmap, Pose2D(0.02, 0.02)).linear <= 0.5
    except NoValidControl as error:
        assert "recover" in str(error)


def test_robot_outside_the_costmap_is_an_error():
    controller = PathIntegral()
    controller.set_plan(along_x(0.5, 2.0))
    with pytest.raises(NoValidControl, match="outside"):
        ask(controller, grids.of(np.zeros((60, 60), np.uint8), 0.05), Pose2D(9.0, 1.2))


def test_unknown_cells_are_free_only_if_allowed():
    costmap = grids.of(np.full((60, 60), 255, np.uint8), 0.05)
    for allowed in (True, False):
        controller = PathIntegral(allow_unknown=allowed)
        controller.set_plan(along_x(0.5, 2.0))
        if allowed:
            assert ask(controller, costmap, Pose2D(0.5, 1.2)).linear > 0.0
        else:
            with pytest.raises(NoValidControl):
                ask(controller, costmap, Pose2D(0.5, 1.2))


@pytest.mark.parametrize("offset", [0.0, 0.1])
def test_robot_stops_if_it_cannot_avoid_a_moving_obstacle(offset):
    cells = np.ones((60, 160), bool)
    cells[20:40] = False  # a corridor of 1 m, too narrow for both
    world, robot = World(cells), Unicycle(Pose2D(1.0, 1.5))
    controller = PathIntegral(robot_radius=RADIUS)
    controller.set_plan(along_x(1.0, 7.0, y=1.5))
    mover, period, fastest = MovingObstacle(5.0, 1.5 + offset, -1.2, 0.0, 0.25), 0.05, 0.0
    while mover.x - robot.pose.x > mover.radius + RADIUS:
        request = ControlRequest(robot.pose, robot.velocity, world.window(robot.pose), period, movers=(mover,))
        try:
            command = controller.compute_velocity(request)
        except NoValidControl:
            command = Velocity()
        for _ in robot.step(command, period):
            pass
        mover, fastest = mover.after(period), max(fastest, robot.velocity.linear)
    assert fastest > 0.3
    assert robot.velocity.linear < 0.05
