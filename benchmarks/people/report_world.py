"""World of points: people who walk and robots that report them, without images, for the coordinator alone."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from ppaas.messages.people_coordination import PeopleReport, SensorView
from ppaas.messages.people_msgs import PositionMeasurement
from ppaas.people.coordinator.visibility import Walls, hidden_by_people, in_views, view_of

Array = NDArray[np.float64]

VIEW = SensorView(0.0, 0.0, 0.0, math.radians(57.0), 0.1, 6.0)
"""View of a depth camera in which people are detected."""
AROUND = SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.0, 8.0)
"""View of a laser that turns."""
BODY = 0.25
"""Radius of a person who hides another [m]."""
NOISE = 0.04
"""Standard deviation of a detected position [m]."""
SPEED = 1.2
"""Speed of people [m/s]."""


@dataclass(slots=True)
class ReportingRobot:
    """A robot of this world.

    Parameters
    ----------
    name : str
    pose : Pose2D
        True pose.
    error : Pose2D
        What it adds to its pose, since it does not know better.
    view : SensorView
    clock : float
        Time that its clock is ahead [s].
    turns : float
        Speed of rotation [rad/s].
    deviation : float
        Standard deviation of the position that it claims [m].
    """

    name: str
    pose: Pose2D
    error: Pose2D = Pose2D(0.0, 0.0, 0.0)
    view: SensorView = VIEW
    clock: float = 0.0
    turns: float = 0.0
    deviation: float = 0.05


class ReportWorld:
    """People who walk between random free places, and robots that see them.

    Parameters
    ----------
    costmap : Costmap
    people : int
    robots : sequence of ReportingRobot
    seed : int
    detected : float
        Probability that a person in view is detected.
    """

    def __init__(
        self, costmap: Costmap, people: int, robots: Sequence[ReportingRobot], seed: int = 0, detected: float = 0.97
    ) -> None:
        self.random = np.random.default_rng(seed)
        self.robots = list(robots)
        self._walls = Walls(costmap)
        self._free = costmap.info.to_world(np.argwhere(costmap.data < 128))
        self._detected = detected
        self.people: Array = self._places(people)
        self._goals = self._places(people)
        self._waits = self.random.uniform(0.0, 5.0, people)

    def _places(self, count: int) -> Array:
        places: Array = self._free[self.random.integers(len(self._free), size=count)]
        return places

    def advance(self, seconds: float) -> None:
        """Let everybody walk for a time [s]; who has arrived or meets a wall waits, and takes another goal."""
        off = self._goals - self.people
        distance = np.hypot(off[:, 0], off[:, 1])
        step = np.minimum(SPEED * seconds / np.maximum(distance, 1e-9), 1.0)[:, np.newaxis] * off
        step[self._waits > 0.0] = 0.0
        self._waits -= seconds
        ahead = self.people + step
        blocked = self._walls.is_wall(ahead + 4.0 * step)
        self.people = np.where(blocked[:, np.newaxis], self.people, ahead)
        done = (distance < 0.1) | blocked
        self._goals = np.where(done[:, np.newaxis], self._places(len(done)), self._goals)
        self._waits = np.where(done & ~blocked, self.random.uniform(0.0, 8.0, len(done)), self._waits)
        for robot in self.robots:
            robot.pose = Pose2D(robot.pose.x, robot.pose.y, robot.pose.theta + seconds * robot.turns)

    def seen_by(self, robot: ReportingRobot, edge: float = 0.0) -> list[int]:
        """Return the numbers of the people that a robot has in view, except an ``edge`` of its view [m]."""
        view = view_of(0, robot.pose, robot.view)
        wide = view.__class__(0, view.pose, view.half_angle + 0.06, view.range_min - 0.4, view.range_max + 0.4 - edge)
        (within,) = in_views([wide], self.people)
        rows, origin = np.flatnonzero(within), np.array(view.pose[:2])
        clear = self._walls.free_between(origin, self.people[rows])
        clear &= ~hidden_by_people(np.broadcast_to(origin, (len(rows), 2)), self.people[rows], self.people, BODY)
        seen: list[int] = rows[clear].tolist()
        return seen

    def report(self, robot: ReportingRobot, now: float) -> PeopleReport:
        """Return what a robot reports at a time [s]; its Torso IDs are the numbers of the people."""
        header = Header(stamp=Time.of(now + robot.clock), frame_id="map")
        believed = Pose2D(
            robot.pose.x + robot.error.x, robot.pose.y + robot.error.y, robot.pose.theta + robot.error.theta
        )
        covariance = [0.0] * 36
        covariance[0] = covariance[7] = robot.deviation**2
        covariance[35] = 0.01**2
        people = []
        for number in self.seen_by(robot):
            if self.random.random() > self._detected:
                continue
            x, y = self.people[number] + self.random.normal(0.0, NOISE, 2)
            local = robot.pose.inverse() @ Pose2D(float(x), float(y))
            spread = [NOISE**2, 0.0, 0.0, 0.0, NOISE**2, 0.0, 0.0, 0.0, 0.01]
            frame = f"{robot.name}/{number}"
            people.append(PositionMeasurement(header, frame, str(number), Point(local.x, local.y), 0.9, spread))
        pose = PoseWithCovariance(Pose.of(believed), covariance)
        return PeopleReport(header, robot.name, pose, people, [robot.view], can_follow=True)
