"""Scene of the warm-up: a round room with a pillar, and an ideal robot that senses both."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan

RADIUS = 2.5
"""Radius of the round room [m]."""

_PILLAR, _GIRTH = (0.6, -0.9), 0.15
"""Centre and radius of the pillar [m], which is not in the map: plans must avoid it."""

_SIDE, _RESOLUTION = 120, 0.05
"""Side of the map [cells] and its resolution [m/cell]."""

Floats = NDArray[np.float64]


def round_room() -> GridMap:
    """Return the map of the room, without the pillar."""
    middles = (np.arange(_SIDE) + 0.5 - _SIDE / 2) * _RESOLUTION
    occupied = np.hypot(middles[:, None], middles) >= RADIUS
    corner = -_SIDE / 2 * _RESOLUTION
    return GridMap(
        np.where(occupied, 100, 0).astype(np.int8), GridInfo(_RESOLUTION, _SIDE, _SIDE, Pose2D(corner, corner))
    )


class SensingRobot:
    """Robot in the round room that drives with the velocity ``command``."""

    def __init__(self) -> None:
        self.command = Twist()
        self._pose = Pose2D(0.0, 0.0)
        self._angles = np.linspace(-math.pi / 2, math.pi / 2, 181)

    def move(self, seconds: float) -> None:
        """Drive for some time [s]."""
        self._pose = self._pose @ Pose2D(self.command.linear.x * seconds, 0.0, self.command.angular.z * seconds)

    def sense(self) -> Iterator[tuple[str, Message]]:
        """Yield the current sensor messages with their topics."""
        stamp = Time.of(epoch())
        pose, twist = PoseWithCovariance(Pose.of(self._pose)), TwistWithCovariance(self.command)
        yield "odom", Odometry(Header(stamp=stamp, frame_id="odom"), "base_link", pose, twist)
        header, angles = Header(stamp=stamp, frame_id="base_link"), self._angles
        first, second, last = map(float, angles[[0, 1, -1]])
        yield "scan", LaserScan(header, first, last, second - first, 0.1, 2.0 * RADIUS, self._ranges())

    def _ranges(self) -> list[float | None]:
        x, y, theta = self._pose
        wall = _to_circle(-x, -y, RADIUS, self._angles + theta)[1]
        pillar = _to_circle(_PILLAR[0] - x, _PILLAR[1] - y, _GIRTH, self._angles + theta)[0]
        ranges: list[float | None] = np.fmin(wall, np.where(pillar > 0.0, pillar, np.nan)).tolist()
        return ranges


def _to_circle(x: float, y: float, radius: float, angles: Floats) -> tuple[Floats, Floats]:
    """Return the distances along each angle [rad] at which a ray enters and leaves a circle [m]; NaN if it misses."""
    along = x * np.cos(angles) + y * np.sin(angles)
    squared = along**2 + radius**2 - x**2 - y**2
    half = np.sqrt(np.where(squared >= 0.0, squared, np.nan))
    return along - half, along + half
