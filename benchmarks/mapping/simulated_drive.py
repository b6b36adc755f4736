"""Simulated drive through walls: true poses, the odometry of bad wheels, and the scans of a laser."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_log import ScanLog
from ppaas.planar_poses import compose, relative


def cast(walls: NDArray[np.float64], origins: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance from each origin (b, 2) to the nearest wall (n, 4) in a direction (b,) [m].

    It is infinite where there is no wall.
    """
    distances: NDArray[np.float64] = _cast(walls, origins, angles)
    return distances


@njit(cache=True, nogil=True, error_model="numpy")
def _cast(walls: Any, origins: Any, angles: Any) -> Any:
    """With × for the cross product, the ray is o + r d and the wall a + t e.

    So r = (a − o) × e / d × e and t = (a − o) × d / d × e. A ray along a wall gives NaN or infinity, and hits nothing.
    """
    distances = np.full(len(origins), np.inf)
    for beam in range(len(origins)):
        x, y = origins[beam, 0], origins[beam, 1]
        c, s = math.cos(angles[beam]), math.sin(angles[beam])
        nearest = np.inf
        for wall in range(len(walls)):
            a, b = walls[wall, 0] - x, walls[wall, 1] - y
            e, f = walls[wall, 2] - walls[wall, 0], walls[wall, 3] - walls[wall, 1]
            per = 1.0 / (c * f - s * e)
            distance = (a * f - b * e) * per
            place = (a * s - b * c) * per
            if 0.0 < distance < nearest and 0.0 <= place <= 1.0:
                nearest = distance
        distances[beam] = nearest
    return distances


SPEED, TURN = 0.5, 0.9
"""Largest velocities of the robot [m/s, rad/s]."""
STEP, EVERY = 0.05, 4
"""Time of a control cycle [s], and number of cycles between two scans."""
ARRIVED = 0.12
"""Distance at which the robot heads for the next way point [m]."""
NOISE, DIGITS = 0.005, 0.01
"""Standard deviation of ranges, and the steps in which they are reported [m]."""
FARTHEST, MISSING = 40.0, 0.02
"""Maximum range [m], and part of the beams without a reading."""
TOO_LONG, JITTER = 0.02, 0.05
"""Relative error of the distance by the odometry: systematic, and random in each step."""
TURN_NOISE = 0.15
"""Relative random error of the turn by the odometry in each step."""


Segments = NDArray[np.float64]
"""Walls (n, 4): x0, y0, x1, y1 [m]."""


@dataclass(frozen=True, slots=True)
class SimulatedDrive:
    """Log of a simulated drive.

    Parameters
    ----------
    log : ScanLog
    true : (n, 3) float64 array
        True pose of the robot at each scan: x, y [m], theta [rad].
    """

    log: ScanLog
    true: NDArray[np.float64]

    def first(self, count: int) -> "SimulatedDrive":
        """Return the first scans of the drive."""
        return SimulatedDrive(self.log.first(count), self.true[:count])

    @property
    def metres(self) -> float:
        """Driven distance [m]."""
        return float(np.hypot(*np.diff(self.true[:, :2], axis=0).T).sum())


def simulate(
    walls: NDArray[np.float64],
    way_points: NDArray[np.float64],
    seed: int,
    *,
    sweep: float = 0.0,
    beams: int = 180,
    mount: Pose2D = Pose2D(0.1, 0.0),
    speed: float = SPEED,
) -> SimulatedDrive:
    """Drive along way points and scan the walls.

    Parameters
    ----------
    walls : (n, 4) array
        Segments: x0, y0, x1, y1 [m].
    way_points : (m, 2) array
        x, y [m].
    seed : int
        Seed of all noise.
    sweep : float
        Time that the laser takes for the beams of a scan [s].
    beams : int
        Number of beams over 180 degrees.
    mount : Pose2D
        Pose of the laser on the robot.
    speed : float
        Largest speed [m/s].
    """
    random = np.random.default_rng(seed)
    true = drive(way_points, speed)[::EVERY]
    geometry = LaserGeometry(-math.pi / 2.0, math.pi / beams, beams, mount, sweep / beams)
    ranges = _scans(walls, compose(true, np.array(mount)), geometry)
    ranges += NOISE * random.standard_normal(ranges.shape)
    ranges = np.round(ranges / DIGITS) * DIGITS
    ranges[(random.random(ranges.shape) < MISSING) | (ranges > FARTHEST)] = np.nan
    stamps = STEP * EVERY * np.arange(len(true), dtype=np.float64)
    first_angles = np.full(len(true), geometry.angle_min)
    return SimulatedDrive(
        ScanLog(stamps, odometry(true, random), ranges.astype(np.float32), first_angles, geometry), true
    )


def drive(way_points: NDArray[np.float64], fastest: float = SPEED) -> NDArray[np.float64]:
    """Return the pose of a robot in each control cycle, which turns to each way point and drives to it."""
    (x, y), theta = way_points[0].tolist(), 0.0
    poses = [(x, y, theta)]
    for goal_x, goal_y in way_points[1:].tolist():
        while math.hypot(goal_x - x, goal_y - y) > ARRIVED:
            off = wrap_angle(math.atan2(goal_y - y, goal_x - x) - theta)
            speed = fastest * max(0.0, math.cos(off)) ** 3 if abs(off) < 1.2 else 0.0
            theta = wrap_angle(theta + STEP * max(-TURN, min(TURN, 2.5 * off)))
            x, y = x + STEP * speed * math.cos(theta), y + STEP * speed * math.sin(theta)
            poses.append((x, y, theta))
    return np.array(poses)


def odometry(true: NDArray[np.float64], random: np.random.Generator) -> NDArray[np.float64]:
    """Return the poses (n, 3) that bad wheels report for true poses; the first is the origin."""
    steps = relative(true[:-1], true[1:])
    forward, turn = np.abs(steps[:, 0]), np.abs(steps[:, 2])
    noise = random.standard_normal(steps.shape)
    steps[:, :2] = (1.0 + TOO_LONG) * steps[:, :2] + noise[:, :2] * (JITTER * forward + 0.001)[:, None]
    steps[:, 2] += noise[:, 2] * (TURN_NOISE * turn + 0.05 * forward + 0.002)
    poses = np.zeros(true.shape)
    for row, step in enumerate(steps):
        poses[row + 1] = compose(poses[row], step)
    return poses


def _scans(walls: NDArray[np.float64], laser: NDArray[np.float64], geometry: LaserGeometry) -> NDArray[np.float64]:
    """Return the exact ranges (n, b); the laser moves steadily during a sweep, in the middle of which its pose is."""
    velocities = np.zeros(laser.shape)
    steps = relative(laser[1:-1], laser[2:]) - relative(laser[1:-1], laser[:-2])
    velocities[1:-1] = steps / (2.0 * STEP * EVERY)
    beams = np.arange(geometry.beams)
    times = (beams - (geometry.beams - 1) / 2.0) * geometry.time_increment
    angles = geometry.angle_min + geometry.angle_increment * beams
    ranges = np.empty((len(laser), geometry.beams))
    for row, (pose, velocity) in enumerate(zip(laser, velocities, strict=True)):
        moved = compose(pose, times[:, None] * velocity)
        ranges[row] = cast(walls, moved[:, :2], moved[:, 2] + angles)
    return ranges


def box(x: float, y: float, width: float, depth: float, theta: float) -> Segments:
    """Return the four edges (4, 4) of a box around a centre [m], turned by an angle [rad]."""
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * (width, depth)
    c, s = np.cos(theta), np.sin(theta)
    turned = corners @ np.array([(c, s), (-s, c)]) + (x, y)
    return np.hstack((turned, np.roll(turned, -1, axis=0)))
