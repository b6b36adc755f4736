"""Lanes in halls without walls, and the cells of robots along them."""

from collections.abc import Sequence

import numpy as np

from ppaas.fleet.lane_drawing import DrawnLane
from ppaas.fleet.lane_roadmap import LaneRoadmap, lane_roadmap
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo

RADIUS, MARGIN = 0.2, 0.1

SPACING = 2.0 * (RADIUS + MARGIN)

INFO = GridInfo(0.1, 200, 120, Pose2D(0.0, 0.0, 0.0))
"""Geometry of a map of 20 by 12 m."""

OPEN = np.full(INFO.shape, 100.0, np.float32)
"""Distances to obstacles, of which there are none [m]."""


def line(*points: Sequence[float], name: str = "", one_way: bool = False) -> DrawnLane:
    """Return a lane through some points; without a name it is called by its first point."""
    return DrawnLane(name or f"{points[0]}", np.array(points, np.float64), one_way)


def ring(x: float, y: float, radius: float, points: int = 60, *, one_way: bool = False) -> DrawnLane:
    """Return a lane along a circle."""
    angles = np.linspace(0.0, 2.0 * np.pi, points)
    return DrawnLane("ring", np.array([x, y]) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), one_way)


SIZES = RobotSizes(RADIUS, MARGIN)


def hall(*lines: DrawnLane) -> LaneRoadmap:
    """Return the cells along lanes in a hall without walls."""
    return lane_roadmap(lines, OPEN, INFO, SIZES)


SITE = (
    line((1, 6), (19, 6), name="main"),
    line((6, 1), (6, 11), name="across"),
    line((3, 6), (3, 10), (6, 10), name="bypass"),
    line((10, 6), (14, 10), (14, 11.5), name="oblique"),
    ring(10, 2.5, 2.2),
    line((10, 4.7), (10, 6), name="feeder"),
    line((16, 6), (16, 2), (19, 2), name="dock"),
)
"""Lanes of a site: crossings, junctions, corners, an oblique lane, a ring and dead ends."""
