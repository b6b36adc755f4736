"""A kinematic robot in a grid of walls, to run a controller in a closed loop."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from benchmarks.navigation.control_cycles import window
from ppaas.controllers.base import Controller, ControlRequest, NoValidControl, Velocity
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, Poses, poses_along, wrap_angle
from ppaas.maps.grid import GridInfo
from ppaas.planners.base import PlanRequest
from ppaas.planners.grid.dijkstra import Dijkstra

RESOLUTION = 0.05
RADIUS = 0.18
PADDING = 0.05
STANDING = Velocity()


@dataclass
class Unicycle:
    """A round robot with limited acceleration; a command takes effect in the cycle after it is given."""

    pose: Pose2D
    acc_lim_x: float = 1.0
    acc_lim_theta: float = 3.0
    velocity: Velocity = STANDING
    _waiting: Velocity = STANDING

    def step(self, command: Velocity, seconds: float) -> Iterator[Pose2D]:
        """Drive one cycle by the previous command; yield the pose after each of ten steps."""
        wanted, self._waiting = self._waiting, command
        dt = seconds / 10
        for _ in range(10):
            v = _limited(self.velocity.linear, wanted.linear, self.acc_lim_x * dt)
            w = _limited(self.velocity.angular, wanted.angular, self.acc_lim_theta * dt)
            self.velocity = Velocity(v, w)
            x, y, theta = self.pose
            self.pose = Pose2D(x + v * dt * math.cos(theta), y + v * dt * math.sin(theta), theta + w * dt)
            yield self.pose


@dataclass
class World:
    """A grid of walls; clearances are exact, while planners see the inflated cells."""

    walls: NDArray[np.bool_]
    costmap: Costmap = field(init=False)
    _corners: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        self.costmap = inflate(self.walls)
        self._corners = np.argwhere(self.walls)[:, ::-1] * RESOLUTION

    def clearance(self, pose: Pose2D) -> float:
        """Return the distance from the robot's rim to the nearest wall, negative in a collision [m]."""
        near = np.clip((pose.x, pose.y), self._corners, self._corners + RESOLUTION) - (pose.x, pose.y)
        return float(np.hypot(near[:, 0], near[:, 1]).min(initial=math.inf)) - RADIUS

    def window(self, pose: Pose2D) -> Costmap:
        """Return the costmap around the robot."""
        return window(self.costmap, pose)


@dataclass
class Drive:
    """Result of a drive."""

    reached: bool
    seconds: float
    clearance: float
    travelled: float
    stuck: int
    end: Pose2D
    commands: list[Velocity]


def drive(world: World, robot: Unicycle, controller: Controller, seconds: float, period: float = 0.1) -> Drive:
    """Drive by a controller until it reports the goal reached or the time is up; stop while it has no velocity."""
    clearance, travelled, stuck = world.clearance(robot.pose), 0.0, 0
    commands: list[Velocity] = []
    for cycle in range(round(seconds / period)):
        if controller.is_goal_reached(robot.pose, robot.velocity):
            return Drive(True, cycle * period, clearance, travelled, stuck, robot.pose, commands)
        request = ControlRequest(robot.pose, robot.velocity, world.window(robot.pose), period)
        try:
            command = controller.compute_velocity(request)
        except NoValidControl:
            command, stuck = Velocity(), stuck + 1
        commands.append(command)
        before = robot.pose
        for pose in robot.step(command, period):
            clearance = min(clearance, world.clearance(pose))
        travelled += before.distance_to(robot.pose)
    return Drive(False, seconds, clearance, travelled, stuck, robot.pose, commands)


BOX = ((0.4, 0.12), (-0.4, 0.12), (-0.4, -0.12), (0.4, -0.12))
"""A robot that is longer than it is wide [m]."""


def gap() -> World:
    """Return a wall across x = 3 m with a gap of 0.6 m at y = 1.5 m."""
    cells = np.zeros((60, 120), bool)
    cells[:, 60:64] = True
    cells[24:36, 60:64] = False
    return World(cells)


def through_gap(controller: Controller, costmap: Costmap, cycles: int) -> list[float]:
    """Send a base without inertia through the gap; return the x of each cycle [m]."""
    controller.set_plan(along_x(2.0, 5.0, y=1.5))
    pose, command, places = Pose2D(2.0, 1.5), STANDING, [2.0]
    for _ in range(cycles):
        try:
            command = controller.compute_velocity(ControlRequest(pose, command, costmap))
        except NoValidControl:
            break
        pose = pose @ Pose2D(command.linear * 0.1, 0.0, command.angular * 0.1)
        places.append(pose.x)
    return places


def inflate(walls: NDArray[np.bool_], scaling: float = 10.0) -> Costmap:
    """Return the costmap of walls, inflated for the robot as in costmap_2d."""
    distance = distance_transform_edt(~walls) * RESOLUTION if walls.any() else np.full(walls.shape, np.inf)
    inscribed = RADIUS + PADDING
    costs = np.where(distance > 0.55, 0.0, 252.0 * np.exp(-scaling * (distance - inscribed)))
    costs[distance <= inscribed] = 253
    costs[walls] = 254
    return Costmap(costs.astype(np.uint8), GridInfo(RESOLUTION, walls.shape[1], walls.shape[0]))


def _limited(now: float, wanted: float, step: float) -> float:
    return now + min(step, max(-step, wanted - now))


OPEN = """
    ##########
    #........#
    #........#
    #........#
    ##########
"""


def along_x(first: float, last: float, y: float = 1.2, goal_theta: float = 0.0) -> Poses:
    """Return a plan along the x axis [m, rad]."""
    x = np.linspace(first, last, 2 + round(abs(last - first) / 0.05))
    return poses_along(np.stack((x, np.full_like(x, y)), axis=1), goal_theta)


def travel(
    controller: Controller, world: World, start: Pose2D, goal: Pose2D, seconds: float = 60.0, period: float = 0.1
) -> Drive:
    """Drive along the cheapest path to a goal."""
    controller.set_plan(Dijkstra().plan(world.costmap, PlanRequest(start, goal)).poses)
    return drive(world, Unicycle(start), controller, seconds, period)


def assert_arrived(result: Drive, goal: Pose2D) -> None:
    """Check that a robot reached its goal without a collision."""
    assert result.reached
    assert result.clearance > 0.0
    assert result.end.distance_to(goal) <= 0.2
    assert abs(wrap_angle(result.end.theta - goal.theta)) <= 0.15
