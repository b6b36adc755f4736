"""Kernels: ray casting in the map, and rating of rays of which some may end at unmapped people."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

NEAR = 1.5
"""Part of the distance between the centres of two cells that lies within the cells [cells], subtracted from a step."""


@compiled
def cast(distance: NDArray[np.float32], x: float, y: float, dx: float, dy: float, most: float, cell: float) -> float:
    """Return the length of a ray to the first occupied cell, to half a cell, or ``most`` if it leaves the map [cells].

    Sphere tracing (Hart, 1996): each step is as long as the distance to the nearest obstacle, at least half a cell.

    Parameters
    ----------
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied one [m].
    x, y : float
        Start of the ray in the frame of the grid [cells].
    dx, dy : float
        Unit direction of the ray.
    most : float
        Largest length [cells].
    cell : float
        Edge of a cell [m].
    """
    height, width = distance.shape
    length = 0.0
    while length < most:
        column, row = math.floor(x + length * dx), math.floor(y + length * dy)
        if not (0 <= row < height and 0 <= column < width):
            return most
        d = distance[np.uint64(row), np.uint64(column)] / cell
        if d == 0.0:
            return length
        length += max(0.5, d - NEAR)
    return most


@compiled
def _is_clear(distance: NDArray[np.float32], x: float, y: float, to_x: float, to_y: float, cell: float) -> bool:
    """Return whether the line between two points [cells] is free; False if the first is outside the map."""
    height, width = distance.shape
    if not (0.0 <= x < width and 0.0 <= y < height):
        return False
    length = math.hypot(to_x - x, to_y - y)
    dx, dy = (to_x - x) / max(length, 1e-9), (to_y - y) / max(length, 1e-9)
    return cast(distance, x, y, dx, dy, length, cell) >= length


@compiled
def _in_cells(pose: NDArray[np.float64], resolution: float, origin: NDArray[np.float64]) -> tuple[float, float]:
    """Return the position of a pose in the frame of the grid [cells]."""
    c0, s0 = math.cos(origin[2]), math.sin(origin[2])
    dx, dy = pose[0] - origin[0], pose[1] - origin[1]
    return (c0 * dx + s0 * dy) / resolution, (c0 * dy - s0 * dx) / resolution


@compiled
def to_walls(
    laser: NDArray[np.float64],
    angles: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    most: float,
) -> NDArray[np.float64]:
    """Return the range of each beam of a laser by ray casting.

    Parameters
    ----------
    laser : (3,) array
        x, y [m], theta [rad] in the map frame.
    angles : (n,) array
        Directions of the beams relative to the laser's heading [rad].
    distance, resolution, origin
        See `explain_rays`.
    most : float
        Longest range [m].

    Returns
    -------
    (n,) array
        Ranges [m]; ``most`` or more without a hit.
    """
    x, y = _in_cells(laser, resolution, origin)
    ranges = np.empty(len(angles))
    for j in range(len(angles)):
        angle = laser[2] + angles[j] - origin[2]
        cells = cast(distance, x, y, math.cos(angle), math.sin(angle), most / resolution, resolution)
        ranges[j] = cells * resolution
    return ranges


@compiled
def explain_rays(
    poses: NDArray[np.float64],
    rays: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    sigma: float,
    person: float,
) -> NDArray[np.float64]:
    """Return for each pose the sum of how well the map explains each ray, from 0 to 1.

    A ray is rated by a Gaussian of the distance from its end to the nearest obstacle. If the rating is below
    ``person``, and the ray reaches its end without passing an obstacle, it is rated ``person``, since an unmapped
    person may stand there. A ray that ends outside the map is rated 0.

    Parameters
    ----------
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame.
    rays : (m, 4) array
        x, y of the end and x, y of the origin of each ray, in the robot's frame [m].
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied one [m].
    resolution : float
        Edge of a cell [m].
    origin : (3,) array
        Pose of the lower-left corner of cell (0, 0) in the map frame [m, m, rad].
    sigma : float
        Standard deviation of a hit [m].
    person : float
        Rating of a ray that may end at a person.

    Returns
    -------
    (n,) array
    """
    height, width = distance.shape
    sums = np.empty(len(poses))
    for i in range(len(poses)):
        x, y = _in_cells(poses[i], resolution, origin)
        heading = poses[i, 2] - origin[2]
        c, s = math.cos(heading) / resolution, math.sin(heading) / resolution
        total = 0.0
        for j in range(len(rays)):
            to_x, to_y = x + c * rays[j, 0] - s * rays[j, 1], y + s * rays[j, 0] + c * rays[j, 1]
            column, row = math.floor(to_x), math.floor(to_y)
            if not (0 <= row < height and 0 <= column < width):
                continue
            hit = math.exp(-0.5 * (distance[row, column] / sigma) ** 2)
            if hit < person:
                from_x, from_y = x + c * rays[j, 2] - s * rays[j, 3], y + s * rays[j, 2] + c * rays[j, 3]
                if _is_clear(distance, from_x, from_y, to_x, to_y, resolution):
                    hit = person
            total += hit
        sums[i] = total
    return sums


@compiled
def stopped_short(
    pose: NDArray[np.float64],
    points: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    beyond: float,
) -> NDArray[np.bool_]:
    """Return which beams end in free space: no obstacle of the map is on them, nor within ``beyond`` behind their ends.

    Parameters
    ----------
    pose : (3,) array
        Pose of the robot: x, y [m], theta [rad] in the map frame.
    points : (m, 2) array
        End points of the beams in the robot's frame [m].
    distance, resolution, origin
        See `explain_rays`.
    beyond : float
        Length behind the end that must be free [m].

    Returns
    -------
    (m,) bool array
    """
    x, y = _in_cells(pose, resolution, origin)
    c, s = math.cos(pose[2] - origin[2]) / resolution, math.sin(pose[2] - origin[2]) / resolution
    short = np.empty(len(points), dtype=np.bool_)
    for j in range(len(points)):
        longer = 1.0 + beyond / max(math.hypot(points[j, 0], points[j, 1]), 1e-9)
        ahead, left = longer * points[j, 0], longer * points[j, 1]
        short[j] = _is_clear(distance, x, y, x + c * ahead - s * left, y + s * ahead + c * left, resolution)
    return short


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    distance = np.zeros((1, 1), dtype=np.float32)
    distance.flags.writeable = False  # like the layers of a map, which all robots share
    explain_rays(np.zeros((1, 3)), np.zeros((1, 4)), distance, 0.05, np.zeros(3), 0.1, 0.5)
    to_walls(np.zeros(3), np.zeros(1), distance, 0.05, np.zeros(3), 8.0)
    stopped_short(np.zeros(3), np.zeros((1, 2)), distance, 0.05, np.zeros(3), 0.1)
