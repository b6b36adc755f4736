"""Laser scans in a room with some furniture, whose walls are line segments."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints, prepare

PARAMETERS = SlamParameters()
LASER = LaserGeometry(-np.pi / 2.0, np.pi / 180.0, 181)
ALL_ROUND = LaserGeometry(0.0, np.pi / 180.0, 360)
CORNERS = [(-4.0, -3.0), (4.0, -3.0), (4.0, 1.0), (6.0, 1.0), (6.0, 3.0), (-4.0, 3.0)]
BOX = [(-1.0, 1.5), (0.0, 1.5), (0.0, 2.0), (-1.0, 2.0)]


def segments(*outlines: list[tuple[float, float]]) -> NDArray[np.float64]:
    """Return the edges (n, 4) of closed outlines: x, y of both ends [m]."""
    return np.concatenate([np.hstack((outline, np.roll(outline, -1, axis=0))) for outline in map(np.array, outlines)])


ROOM = segments(CORNERS, BOX)
CORRIDOR = np.array([(-50.0, -1.0, 50.0, -1.0), (-50.0, 1.0, 50.0, 1.0)])


def ranges_at(
    pose: ArrayLike, laser: LaserGeometry = LASER, walls: NDArray[np.float64] = ROOM, noise: float = 0.0, seed: int = 0
) -> NDArray[np.float32]:
    """Return the ranges of a scan [m]; infinite without a hit."""
    x, y, theta = np.asarray(pose, np.float64)
    angles = theta + laser.angle_min + laser.angle_increment * np.arange(laser.beams)
    dx, dy = np.cos(angles)[:, None], np.sin(angles)[:, None]
    ax, ay = walls[:, 0] - x, walls[:, 1] - y
    ex, ey = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        across = dx * ey - dy * ex
        reach, part = (ax * ey - ay * ex) / across, (ax * dy - ay * dx) / across
    hit = (reach > 0.0) & (part >= 0.0) & (part <= 1.0)
    ranges = np.where(hit, reach, np.inf).min(axis=1)
    return (ranges + noise * np.random.default_rng(seed).standard_normal(laser.beams)).astype(np.float32)


def scan_at(
    pose: ArrayLike, laser: LaserGeometry = LASER, walls: NDArray[np.float64] = ROOM, noise: float = 0.0, seed: int = 0
) -> ScanPoints:
    """Return the points of a scan."""
    return prepare(ranges_at(pose, laser, walls, noise, seed), laser, PARAMETERS)
