"""Physics of a Turtlebot in a room."""

import ast
import math
from collections.abc import Callable

import numpy as np
import pytest

from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.demo.scorer import Scorer
from robots.sim.bodies.furniture import column
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel, TurtlebotModel
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.sources import sources
from tests.support.world.rooms import room

NO_SLIP = SimulatedRobotModel(base=TurtlebotModel(slip=0.0))


def drive(
    world: World, seconds: float, commands: dict[SimulatedRobot, tuple[float, float]],
    each_step: Callable[[], None] = lambda: None,
) -> None:  # fmt: skip
    """Repeat a command for a time."""
    for _ in range(round(seconds / world.dt)):
        for robot, (linear, angular) in commands.items():
            robot.command(Twist(Vector3(x=linear), Vector3(z=angular)))
        world.step()
        each_step()


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, -2.0])
def test_the_robot_drives_straight_along_its_heading(heading: float) -> None:
    world = World(room(10.0, 10.0))
    robot = world.add_robot(Pose2D(5.0, 5.0, heading), NO_SLIP)
    drive(world, 4.0, {robot: (0.5, 0.0)})
    # The ramp up to 0.5 m/s at 1 m/s² takes half a second and costs an eighth of a metre.
    ahead = Pose2D(5.0, 5.0, heading).inverse() @ robot.base.pose
    assert ahead.x == pytest.approx(4.0 * 0.5 - 0.125, abs=0.02)
    assert ahead.y == pytest.approx(0.0, abs=1e-6)
    assert ahead.theta == pytest.approx(0.0, abs=1e-6)
    assert Scorer(world).distance(0) == pytest.approx(ahead.x, abs=1e-6)


def test_the_robot_turns_in_place_counter_clockwise() -> None:
    world = World(room(10.0, 10.0))
    robot = world.add_robot(Pose2D(5.0, 5.0, 0.0), NO_SLIP)
    drive(world, 2.0, {robot: (0.0, 1.0)})
    ramp = 1.0**2 / (2.0 * 4.0)
    assert robot.base.pose.theta == pytest.approx(2.0 - ramp, abs=0.03)
    assert robot.base.pose.distance_to(Pose2D(5.0, 5.0)) < 1e-6


def test_speed_and_acceleration_respect_the_limits_of_the_base() -> None:
    world = World(room(40.0, 40.0))
    robot = world.add_robot(Pose2D(20.0, 20.0, 0.0))
    model = robot.model.base
    speeds: list[Velocity] = []
    drive(world, 2.0, {robot: (100.0, 100.0)}, lambda: speeds.append(robot.base.wheels))
    drive(world, 2.0, {robot: (-100.0, -100.0)}, lambda: speeds.append(robot.base.wheels))
    wheels = np.array([(0.0, 0.0), *speeds])
    assert np.abs(wheels).max(axis=0) == pytest.approx([model.max_linear, model.max_angular])
    steps = np.abs(np.diff(wheels, axis=0)).max(axis=0)
    assert steps == pytest.approx([model.acc_linear * world.dt, model.acc_angular * world.dt])


def test_the_robot_stops_without_commands() -> None:
    world = World(room(10.0, 10.0))
    robot = world.add_robot(Pose2D(5.0, 5.0, 0.0))
    drive(world, 1.0, {robot: (0.5, 0.0)})
    drive(world, 2.0, {})
    assert robot.base.wheels == Velocity(0.0, 0.0)
    resting = robot.base.pose
    drive(world, 1.0, {})
    assert robot.base.pose == resting


@pytest.mark.parametrize("origin", [Pose2D(0.0, 0.0), Pose2D(-3.0, 7.0, 0.7)])
@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, 0.3])
def test_a_wall_stops_the_robot_and_counts_as_one_contact(heading: float, origin: Pose2D) -> None:
    grid = room(4.0, 4.0, origin=origin)
    world = World(grid)
    robot = world.add_robot(origin @ Pose2D(2.0, 2.0, heading))
    drive(world, 8.0, {robot: (0.5, 0.0)})
    local = origin.inverse() @ robot.base.pose
    inner = 0.05 + robot.model.base.radius
    for coordinate in (local.x, local.y):
        assert inner - 0.01 <= coordinate <= 4.0 - inner + 0.01
    assert max(abs(local.x - 2.0), abs(local.y - 2.0)) == pytest.approx(2.0 - inner, abs=0.01)
    assert Scorer(world).collisions(0) == 1


def test_returning_to_the_wall_is_another_contact() -> None:
    world = World(room(4.0, 4.0))
    robot = world.add_robot(Pose2D(3.0, 2.0, 0.0))
    for count in (1, 2):
        drive(world, 4.0, {robot: (0.5, 0.0)})
        assert Scorer(world).collisions(0) == count
        drive(world, 3.0, {robot: (-0.3, 0.0)})


def test_sliding_along_a_rough_wall_is_one_contact() -> None:
    grid = room(8.0, 4.0)
    rough = grid.data.copy()
    rough[-1, ::2] = rough[-2, ::3] = 100
    world = World(GridMap(rough, grid.info))
    robot = world.add_robot(Pose2D(1.0, 3.5, 0.2))
    for _ in range(500):
        drive(world, world.dt, {robot: (0.4, 5.0 * (0.2 - robot.base.pose.theta))})
    assert robot.base.pose.x > 3.0
    assert world.contacts.wall_contacts[0] == 1


def test_robots_that_collide_have_one_contact_each() -> None:
    world = World(room(8.0, 4.0))
    left, right = world.add_robot(Pose2D(2.0, 2.0, 0.0)), world.add_robot(Pose2D(5.0, 2.0, math.pi))
    bystander = world.add_robot(Pose2D(4.0, 3.5, 0.0))
    drive(world, 5.0, {left: (0.4, 0.0), right: (0.4, 0.0)})
    gap = left.base.pose.distance_to(right.base.pose) - 2.0 * left.model.base.radius
    assert gap == pytest.approx(0.0, abs=0.01)
    assert world.contacts.robot_contacts == {0: 1, 1: 1}
    scorer = Scorer(world)
    assert [scorer.collisions(robot) for robot in range(3)] == [1, 1, 0]
    assert scorer.error(2, Pose2D(4.0, 3.5)) < 1e-9
    assert bystander.base.pose == Pose2D(4.0, 3.5, 0.0)


def test_unknown_cells_are_no_obstacles() -> None:
    grid = GridMap(np.full((80, 80), UNKNOWN, np.int8), GridInfo(0.05, 80, 80))
    world = World(grid)
    robot = world.add_robot(Pose2D(1.0, 2.0, 0.0))
    drive(world, 4.0, {robot: (0.5, 0.0)})
    assert robot.base.pose.x > 2.5
    assert all(distance is None for distance in robot.scan().ranges)


def run(seed: int, robots: int) -> list[object]:
    world = World(room(6.0, 6.0), seed=seed)
    for index in range(robots):
        world.add_robot(Pose2D(2.0 + 2.0 * index, 3.0, 0.5))
    drive(world, 2.0, dict.fromkeys(world.robots, (0.3, 0.4)))
    first = world.robots[0]
    return [first.base.pose, first.odometry(), first.scan() if robots == 1 else None]


def test_worlds_differ_only_by_the_seed() -> None:
    assert run(7, 1) == run(7, 1)
    for ours, others in zip(run(7, 1), run(8, 1), strict=True):
        assert ours != others


def test_the_noise_of_a_robot_does_not_depend_on_the_others() -> None:
    assert run(7, 1)[:2] == run(7, 2)[:2]


def test_slip_makes_the_true_path_deviate_from_the_wheels() -> None:
    world = World(room(40.0, 10.0), seed=3)
    robot = world.add_robot(Pose2D(5.0, 5.0, 0.0), SimulatedRobotModel(base=TurtlebotModel(slip=0.1)))
    drive(world, 20.0, {robot: (0.5, 0.0)})
    rolled = 20.0 * 0.5 - 0.125
    assert 0.001 < abs(robot.base.travelled - rolled) < 0.1 * rolled
    assert abs(wrap_angle(robot.base.pose.theta)) < 0.05


def test_a_pose_that_is_not_finite_is_refused() -> None:
    with pytest.raises(InvalidInput, match="finite"):
        World(room(4.0, 4.0)).add_robot(Pose2D(math.nan, 0.0))


def test_stamps_start_at_the_epoch_and_advance_with_the_steps() -> None:
    world = World(room(4.0, 4.0), dt=0.02, epoch=1000.0)
    robot = world.add_robot(Pose2D(2.0, 2.0))
    drive(world, 1.0, {})
    assert robot.odometry().header.stamp.seconds() == pytest.approx(1001.0)
    assert robot.scan().header.stamp == robot.odometry().header.stamp


def test_lasers_and_cameras_see_the_bodies_of_people_and_furniture() -> None:
    world = World(room(8.0, 6.0), bodies=True)
    world.add_furniture(column(Pose2D(5.0, 4.5), 0.2))
    robot = world.add_robot(Pose2D(3.0, 3.0), SimulatedRobotModel(camera=DepthCameraModel(width=64, height=48)))
    empty = robot.depths()
    person = world.add_actor(ShortestPaths(world.grid, 0.35, np.random.default_rng(1)), Pose2D(5.0, 3.0), iter([]))
    world.step()
    ranges = np.array([value or math.inf for value in robot.scan().ranges])
    near = ranges[(ranges > 1.85) & (ranges < 2.1)]
    # Two legs of 5 cm radius cover six beams or more, but not as many as a disc of 25 cm.
    assert 4 <= len(near) <= 10
    assert person.body.position == pytest.approx((5.0, 3.0))
    seen = robot.depths()
    nearer = (seen > 1700) & (seen < 2100) & (seen != empty)
    assert nearer[:, 28:36].any(axis=1).sum() > 25
    assert not nearer[:, :20].any()


def test_cameras_see_other_robots() -> None:
    world = World(room(8.0, 6.0))
    robot = world.add_robot(Pose2D(2.0, 3.0), SimulatedRobotModel(camera=DepthCameraModel(width=64, height=48)))
    alone = robot.depths()
    world.add_robot(Pose2D(5.0, 3.0))
    assert (np.abs(robot.depths().astype(int) - alone)[26:, 28:36] > 300).any()


def test_a_robot_without_a_camera_says_so() -> None:
    with pytest.raises(InvalidInput, match="no depth camera"):
        World(room(4.0, 4.0)).add_robot(Pose2D(2.0, 2.0)).depths()


READERS_OF_THE_TRUTH = {
    "robots/sim/docks/fitting.py", "benchmarks/building/docking_scene.py",  # charges a robot whose contacts touch
    "robots/sim/docks/shelf.py",  # lifts a shelf that is above the robot
    "robots/sim/robot.py", "robots/sim/world.py", "robots/sim/contacts.py",
    "robots/sim/pedestrian.py", "robots/sim/actors.py", "robots/demo/scorer.py",
    "robots/sim/floors/car.py",  # carries robots that are in it
    "robots/sim/floors/ride_log.py", "robots/sim/floors/track.py",  # score and draw runs
    "benchmarks/localization/run.py",  # scores localization, and drives by the true pose
    "benchmarks/localization/crowd.py",  # places people around the true position of the robot
    # score goals, and draw how they went
    "robots/demo/contact_referee.py", "benchmarks/navigation/goals/run.py",
    "robots/demo/people.py", "robots/demo/people_truth.py",  # registers the robots at their starts; scores people
    "benchmarks/navigation/goals/picture.py",
    # carry out what robots measure of people, and score it
    "benchmarks/people/runs/scene.py", "benchmarks/people/runs/robot.py",
    "benchmarks/people/bandwidth.py", "benchmarks/people/legs.py",
    "benchmarks/imports/drives.py",  # measures how far a robot is from its goal
    "robots/sim/mavlink/rover.py",  # an autopilot, which localizes itself
    "benchmarks/fleet/traffic.py",  # places robots at their starts, and measures how near they come
    "benchmarks/service/dashboard_under_load.py",  # registers the robots at their starts
    "benchmarks/chaos/robot_under_test.py",  # tells how far a robot is from a goal that does not end
}  # fmt: skip


def reads_the_truth(tree: ast.Module) -> bool:
    """Return whether a module reads a robot's body."""
    return any(
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Attribute)
        and node.value.attr in ("base", "body")
        for node in ast.walk(tree)
    )


def test_only_world_and_scorers_read_the_true_pose() -> None:
    found = {source.path for source in sources("robots", "benchmarks") if reads_the_truth(source.tree)}
    assert found <= READERS_OF_THE_TRUTH
    assert "robots/demo/scorer.py" in found
