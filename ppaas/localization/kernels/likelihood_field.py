"""Kernel: fit of a scan from each particle by the likelihood field (*Probabilistic Robotics*, 6.4, table 6.3)."""

import math
from collections.abc import Callable

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

FAR = 9.0
"""Standard deviations beyond which the likelihood of a hit is taken to be constant."""

MOST_SQUARES = 1 << 20
"""Largest number of entries of a table, by squared distance in cells: 50 m with cells of 0.05 m."""

ONE = float(1 << 40)
"""Scale of the integers in a table. Sums of integers do not depend on the order of the terms."""

Score = Callable[
    [NDArray[np.float64], NDArray[np.float64], NDArray[np.float32], float, NDArray[np.float64], NDArray[np.int64]],
    NDArray[np.float64],
]


def likelihoods(
    resolution: float, z_hit: float, z_random: float, sigma: float, max_distance: float
) -> NDArray[np.float64]:
    """Return the likelihood of a beam by the distance from its end to the nearest obstacle.

    Parameters
    ----------
    resolution : float
        Edge of a cell [m].
    z_hit, z_random : float
        Weight of beams that hit the map, and density of random beams (their weight / longest range).
    sigma : float
        Standard deviation of a hit [m].
    max_distance : float
        Distance that counts for ends which are farther from any obstacle, or outside the map [m].

    Returns
    -------
    (k,) array
        Likelihoods by squared distance in cells.
    """
    far = min(max_distance, FAR * sigma)
    squares = np.arange(min(math.ceil((far / resolution) ** 2), MOST_SQUARES) + 1)
    distance = np.minimum(resolution * np.sqrt(squares), max_distance)
    distance[-1] = max_distance
    found: NDArray[np.float64] = z_hit * np.exp(-0.5 * (distance / sigma) ** 2) + z_random
    return found


@compiled
def _score_particle(
    x: float,
    y: float,
    cosine: float,
    sine: float,
    beams: NDArray[np.float64],
    flat: NDArray[np.float32],
    height: int,
    width: int,
    to_square: float,
    table: NDArray[np.int64],
) -> int:
    """Return the sum of table entries of one particle, whose pose is given in cells.

    The loop writes nothing and adds integers, so that compilers can vectorize it.

    Parameters
    ----------
    x, y : float
        Position of the particle in the frame of the grid [cells].
    cosine, sine : float
        Rotation of the particle, divided by the resolution [cells/m].
    beams : (2, m) array
        x and y of the ends of the beams in the robot's frame [m].
    flat : (height * width,) float32 array
        Distances to the nearest obstacle, row by row [m].
    height, width : int
        Size of the map [cells].
    to_square : float
        Factor from squared metres to squared cells.
    table : (k,) int64 array
        Terms by squared distance in cells.
    """
    last = float(table.shape[0] - 1)
    total = 0
    for j in range(beams.shape[1]):
        column = x + cosine * beams[0, j] - sine * beams[1, j]
        row = y + sine * beams[0, j] + cosine * beams[1, j]
        inside = (column >= 0.0) & (column < width) & (row >= 0.0) & (row < height)
        # Unsigned indices spare numba the check for negative ones.
        cell = np.int64(np.int32(row if inside else 0.0)) * width + np.int64(np.int32(column if inside else 0.0))
        d = float(flat[np.uint64(cell)])
        square = min(d * d * to_square + 0.5, last) if inside else last
        total += table[np.uint64(np.int32(square))]
    return total


def _score_scan(
    particles: NDArray[np.float64],
    beams: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    table: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Return for each particle the sum of a table's terms over the ends of all beams.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad] of the robot in the map frame.
    beams : (m, 2) array
        End points of the beams in the robot's frame [m].
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied one [m]. Its square is an integer in cells, so that terms can be
        looked up by it instead of computing exponentials in the loop.
    resolution : float
        Edge of a cell [m].
    origin : (3,) array
        Pose of the lower-left corner of cell (0, 0) in the map frame [m, m, rad].
    table : (k,) int64 array
        Terms of a beam in units of 1 / `ONE`, by squared distance in cells; the last one applies to larger distances
        and outside the map.

    Returns
    -------
    (n,) array
        The same for any number of threads.
    """
    height, width = distance.shape
    flat = distance.ravel()
    ends = np.ascontiguousarray(beams.T)
    c0, s0 = math.cos(origin[2]), math.sin(origin[2])
    to_square = 1.0 / (resolution * resolution)
    sums = np.empty(particles.shape[0])
    for i in prange(particles.shape[0]):
        # Pose of the particle in the frame of the grid, in cells, so that each beam takes one rotation.
        dx, dy = particles[i, 0] - origin[0], particles[i, 1] - origin[1]
        x, y = (c0 * dx + s0 * dy) / resolution, (c0 * dy - s0 * dx) / resolution
        heading = particles[i, 2] - origin[2]
        cosine, sine = math.cos(heading) / resolution, math.sin(heading) / resolution
        sums[i] = _score_particle(x, y, cosine, sine, ends, flat, height, width, to_square, table) / ONE
    return sums


score_parallel: Score = compiled(parallel=True)(_score_scan)
score_serial: Score = compiled(serial_copy(_score_scan))


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    distance = np.zeros((1, 1), dtype=np.float32)
    distance.flags.writeable = False  # like the layers of a map, which all robots share
    for score in (score_serial, score_parallel):
        score(np.zeros((1, 3)), np.zeros((1, 2)), distance, 0.05, np.zeros(3), np.ones(1, np.int64))
