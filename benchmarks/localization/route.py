"""Endless route of a robot from goal to goal, and the controller that follows it."""

import math

import numpy as np

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.courses import GoalRules
from robots.sim.shortest_paths import PathWalk, ShortestPaths

AHEAD, CREEP_AHEAD = 0.5, 0.15
"""Lookahead distances along the path, of a robot that drives and of one that creeps [m]."""
SPEED, TURN = 0.5, 1.5
"""Maximum velocities [m/s, rad/s]."""
CREEP, CREEP_TURN = 0.01, 0.01
"""Maximum velocities of a robot that creeps [m/s, rad/s]."""
SHARP = 0.8
"""Bearing of the path beyond which the robot turns in place [rad]."""
ALIGNED = 0.06
"""The same for a robot that creeps, which turns as slowly as it drives [rad]."""
NEAREST_GOAL = 5.0
"""Smallest distance to a goal if the map is large enough [m]."""


class RandomRoute:
    """An endless route through random goals of a map.

    Parameters
    ----------
    grid : GridMap
    rng : numpy.random.Generator
        Random source of the goals.

    Raises
    ------
    InvalidMap
        The map has no free space for a robot.
    """

    def __init__(self, grid: GridMap, rng: np.random.Generator) -> None:
        self._ways = ShortestPaths(grid, GoalRules().clearance, rng)
        self.begin(self._ways.anywhere())

    def anywhere(self) -> Pose2D:
        """Return a random pose in free space."""
        return self._ways.anywhere()

    def begin(self, start: Pose2D) -> None:
        """Start a new path from a pose."""
        self._end, self._way = start, PathWalk(np.array([start[:2]]))

    def steer(self, pose: Pose2D) -> Twist:
        """Return the velocity that follows the route from a pose."""
        bearing = self._bearing(pose, AHEAD)
        speed = SPEED * math.cos(bearing) if abs(bearing) < SHARP else 0.0
        return Twist(Vector3(x=speed), Vector3(z=min(max(2.5 * bearing, -TURN), TURN)))

    def creep(self, pose: Pose2D) -> Twist:
        """Return the velocity that follows the route from a pose very slowly."""
        bearing = self._bearing(pose, CREEP_AHEAD)
        speed = CREEP if abs(bearing) < ALIGNED else 0.0
        return Twist(Vector3(x=speed), Vector3(z=min(max(bearing, -CREEP_TURN), CREEP_TURN)))

    def _bearing(self, pose: Pose2D, ahead: float) -> float:
        """Return the bearing of the route at a distance ahead of a pose [rad]."""
        while self._way.ended:
            goal = self._ways.away_from(self._end, NEAREST_GOAL)
            self._end, self._way = goal, PathWalk(self._ways.between(self._end, goal))
        x, y = self._way.ahead(pose.x, pose.y, ahead)
        return wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.theta)
