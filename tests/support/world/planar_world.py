"""A small simulated world without I/O: a walled map with boxes, a unicycle, drifting odometry and a laser."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.maps.raycast import cast_rays
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan

Box = tuple[float, float, float, float]
"""Least x and y, greatest x and y [m]."""


def walled_map(width: float, height: float, boxes: list[Box], resolution: float = 0.05) -> GridMap:
    """Return a rectangular map with walls around it and boxes inside; its lower-left corner is the origin."""
    data = np.full((round(height / resolution), round(width / resolution)), FREE, dtype=np.int8)
    info = GridInfo(resolution, data.shape[1], data.shape[0])
    data[:2] = data[-2:] = OCCUPIED
    data[:, :2] = data[:, -2:] = OCCUPIED
    for box in boxes:
        fill(data, info, box)
    return GridMap(data, info)


def fill(data: NDArray[np.int8], info: GridInfo, box: Box) -> None:
    """Make the cells of a box occupied."""
    (r0, c0), (r1, c1) = info.to_cells([box[:2], box[2:]])
    data[r0:r1, c0:c1] = OCCUPIED


@dataclass
class World:
    """The true world, a robot in it, and its sensors.

    ``drift`` scales the systematic error of the odometry: 1 means 1 % in length and 0.02 rad per metre.
    """

    grid: GridMap
    pose: Pose2D
    drift: float = 1.0
    beams: int = 180
    range_max: float = 8.0
    noise: float = 0.01
    seed: int = 1
    velocity: tuple[float, float] = (0.0, 0.0)
    odom: Pose2D = Pose2D(0.0, 0.0)
    truth: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        self.truth = self.grid.data >= 50
        self.random = np.random.default_rng(self.seed)

    def move(self, linear: float, angular: float, seconds: float, steps: int = 5) -> None:
        """Move the robot at constant velocities for a time [s], and add drift to its odometry."""
        self.velocity = (linear, angular)
        dt = seconds / steps
        for _ in range(steps):
            step, turn = linear * dt, angular * dt
            self.pose = Pose2D(*self.pose) @ Pose2D(step * math.cos(turn / 2), step * math.sin(turn / 2), turn)
            wrong_step = step * (1.0 + 0.01 * self.drift)
            wrong_turn = turn * (1.0 + 0.01 * self.drift) + 0.02 * self.drift * abs(step)
            self.odom = self.odom @ Pose2D(
                wrong_step * math.cos(wrong_turn / 2), wrong_step * math.sin(wrong_turn / 2), wrong_turn
            )

    def clearance(self) -> float:
        """Return the distance from the robot's centre to the nearest occupied cell [m], up to 1 m."""
        info = self.grid.info
        row, column = info.to_cells(self.pose[:2])
        reach = round(1.0 / info.resolution)
        r0, c0 = max(row - reach, 0), max(column - reach, 0)
        near = np.argwhere(self.truth[r0 : row + reach, c0 : column + reach])
        if not len(near):
            return 1.0
        centres = info.to_world(near + np.array((r0, c0)))
        apart = np.maximum(np.abs(centres - self.pose[:2]) - info.resolution / 2, 0.0)
        return float(np.hypot(apart[:, 0], apart[:, 1]).min())

    def ranges(self) -> NDArray[np.float64]:
        """Return what the laser measures; infinite where there is nothing."""
        angles = np.linspace(-math.pi, math.pi, self.beams, endpoint=False)
        exact = cast_rays(self.truth, self.grid.info, self.pose, angles, self.range_max)
        return exact + self.random.normal(0.0, self.noise, self.beams)

    def scan(self, stamp: float) -> LaserScan:
        """Return the scan as a robot sends it: no hit is null."""
        ranges = [r if math.isfinite(r) else None for r in self.ranges().tolist()]
        return LaserScan(
            Header(stamp=Time.of(stamp), frame_id="base_scan"),
            angle_min=-math.pi,
            angle_max=math.pi,
            angle_increment=2.0 * math.pi / self.beams,
            range_min=0.05,
            range_max=self.range_max,
            ranges=ranges,
        )

    def odometry(self, stamp: float) -> Odometry:
        """Return the odometry as a robot sends it."""
        twist = Twist(Vector3(x=self.velocity[0]), Vector3(z=self.velocity[1]))
        return Odometry(
            Header(stamp=Time.of(stamp), frame_id="odom"),
            "base_link",
            PoseWithCovariance(Pose.of(self.odom)),
            TwistWithCovariance(twist),
        )


def error_of(estimate: Pose2D, true: Pose2D) -> tuple[float, float]:
    """Return the distance and the angle between two poses [m, rad]."""
    return estimate.distance_to(true), abs(wrap_angle(estimate.theta - true.theta))
