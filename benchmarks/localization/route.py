"""Where a robot drives: from goal to goal, and how it follows the way."""

import math

import numpy as np

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.courses import GoalRules
from robots.sim.shortest_paths import PathWalk, ShortestPaths

AHEAD = 0.5
"""How far along the way it steers for [m]."""
SPEED, TURN = 0.5, 1.5
"""[m/s, rad/s]"""
SHARP = 0.8
"""With its way farther to the side than this it turns in place [rad]."""
NEAREST_GOAL = 5.0
"""No goal is nearer than this, where the map is large enough [m]."""


class Route:
    """An endless way through a map from one goal to the next, each anywhere.

    Parameters
    ----------
    grid : GridMap
    rng : numpy.random.Generator
        Decides.

    Raises
    ------
    InvalidMap
        There is no room for a robot.
    """

    def __init__(self, grid: GridMap, rng: np.random.Generator) -> None:
        self._ways = ShortestPaths(grid, GoalRules().clearance, rng)
        self.begin(self._ways.anywhere())

    def anywhere(self) -> Pose2D:
        """Return a pose that a robot may have."""
        return self._ways.anywhere()

    def begin(self, start: Pose2D) -> None:
        """Go on from elsewhere."""
        self._end, self._way = start, PathWalk(np.array([start[:2]]))

    def steer(self, pose: Pose2D) -> Twist:
        """Return the velocity that leads a robot on."""
        while self._way.ended:
            goal = self._ways.away_from(self._end, NEAREST_GOAL)
            self._end, self._way = goal, PathWalk(self._ways.between(self._end, goal))
        x, y = self._way.ahead(pose.x, pose.y, AHEAD)
        bearing = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.theta)
        speed = SPEED * math.cos(bearing) if abs(bearing) < SHARP else 0.0
        return Twist(Vector3(x=speed), Vector3(z=min(max(2.5 * bearing, -TURN), TURN)))
