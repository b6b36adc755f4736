"""Kernels: how well the map accounts for rays, of which some may have met somebody whom the map does not know."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEAR = 1.5
"""What two cells take up of the distance between their centres [cells]; nearer, a ray goes on by half a cell."""


@njit(cache=True, nogil=True, error_model="numpy")
def cast(distance: NDArray[np.float32], x: float, y: float, dx: float, dy: float, most: float, cell: float) -> float:
    """Return how many cells a ray goes until it meets an occupied one, to half a cell; ``most`` if it leaves the map.

    It goes as far at a time as the distance to the nearest obstacle lets it (sphere tracing).
    """
    height, width = distance.shape
    gone = 0.0
    while gone < most:
        column, row = math.floor(x + gone * dx), math.floor(y + gone * dy)
        if not (0 <= row < height and 0 <= column < width):
            return most
        d = distance[np.uint64(row), np.uint64(column)] / cell
        if d == 0.0:
            return gone
        gone += max(0.5, d - NEAR)
    return most


@njit(cache=True, nogil=True, error_model="numpy")
def _is_clear(distance: NDArray[np.float32], x: float, y: float, to_x: float, to_y: float, cell: float) -> bool:
    """Tell whether nothing of the map is between two points, given in cells; the first lies in the map, too."""
    height, width = distance.shape
    if not (0.0 <= x < width and 0.0 <= y < height):
        return False
    length = math.hypot(to_x - x, to_y - y)
    dx, dy = (to_x - x) / max(length, 1e-9), (to_y - y) / max(length, 1e-9)
    return cast(distance, x, y, dx, dy, length, cell) >= length


@njit(cache=True, nogil=True, error_model="numpy")
def _in_cells(pose: NDArray[np.float64], resolution: float, origin: NDArray[np.float64]) -> tuple[float, float]:
    """Return where a pose lies, counted in cells of the grid."""
    c0, s0 = math.cos(origin[2]), math.sin(origin[2])
    dx, dy = pose[0] - origin[0], pose[1] - origin[1]
    return (c0 * dx + s0 * dy) / resolution, (c0 * dy - s0 * dx) / resolution


@njit(cache=True, nogil=True, error_model="numpy")
def to_walls(
    laser: NDArray[np.float64],
    angles: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    most: float,
) -> NDArray[np.float64]:
    """Return how far each beam of a laser would go.

    Parameters
    ----------
    laser : (3,) array
        x, y [m], theta [rad] in the map frame.
    angles : (n,) array
        Of the beams, from its heading [rad].
    distance, resolution, origin
        As `account_for` takes them.
    most : float
        Longest range [m].

    Returns
    -------
    (n,) array
        [m]; ``most`` or more where nothing is met.
    """
    x, y = _in_cells(laser, resolution, origin)
    gone = np.empty(len(angles))
    for j in range(len(angles)):
        angle = laser[2] + angles[j] - origin[2]
        cells = cast(distance, x, y, math.cos(angle), math.sin(angle), most / resolution, resolution)
        gone[j] = cells * resolution
    return gone


@njit(cache=True, nogil=True, error_model="numpy")
def account_for(
    poses: NDArray[np.float64],
    rays: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    sigma: float,
    somebody: float,
) -> NDArray[np.float64]:
    """Sum up how well rays are accounted for as seen from each pose: each by 0 to 1.

    One that ends at an obstacle counts by a Gaussian of how far from it. One that ends in the open counts
    ``somebody``, if that is more and nothing of the map is in its way: who stands there is in no map. One that went
    through an obstacle, or out of the map, has nothing else to its credit.

    Parameters
    ----------
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame.
    rays : (m, 4) array
        x, y where each ended, and where it began, in the robot's frame [m].
    distance : (height, width) array
        From each cell to the nearest occupied one [m].
    resolution : float
        Edge of a cell [m].
    origin : (3,) array
        Pose of the lower-left corner of cell (0, 0) in the map frame [m, m, rad].
    sigma : float
        Standard deviation of a hit [m].
    somebody : float
        As above.

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
            if hit < somebody:
                from_x, from_y = x + c * rays[j, 2] - s * rays[j, 3], y + s * rays[j, 2] + c * rays[j, 3]
                if _is_clear(distance, from_x, from_y, to_x, to_y, resolution):
                    hit = somebody
            total += hit
        sums[i] = total
    return sums


@njit(cache=True, nogil=True, error_model="numpy")
def stopped_short(
    pose: NDArray[np.float64],
    points: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    beyond: float,
) -> NDArray[np.bool_]:
    """Tell which beams ended where nothing of the map is, nor on the way there, nor for some way beyond.

    Parameters
    ----------
    pose : (3,) array
        From where they are seen: x, y [m], theta [rad] in the map frame.
    points : (m, 2) array
        Where each ended, in the robot's frame [m].
    distance, resolution, origin
        As `account_for` takes them.
    beyond : float
        How far beyond [m].

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
    """Compile, or load what was compiled."""
    distance = np.zeros((1, 1), dtype=np.float32)
    distance.flags.writeable = False  # as layers of a map are, which all robots share
    account_for(np.zeros((1, 3)), np.zeros((1, 4)), distance, 0.05, np.zeros(3), 0.1, 0.5)
    to_walls(np.zeros(3), np.zeros(1), distance, 0.05, np.zeros(3), 8.0)
    stopped_short(np.zeros(3), np.zeros((1, 2)), distance, 0.05, np.zeros(3), 0.1)
