"""How well a scan fits the map as seen from each particle."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FAR = 9.0
"""Standard deviations beyond which a hit is as good as impossible: what it adds is below what a weight can hold."""

MOST_SQUARES = 1 << 20
"""Most squares of distances in cells that are told apart: up to 50 m at 0.05 m a cell."""


def likelihoods(
    resolution: float, z_hit: float, z_random: float, sigma: float, max_distance: float
) -> NDArray[np.float64]:
    """Return what a beam adds to the weight of a particle, by how far from an obstacle it ends.

    Parameters
    ----------
    resolution : float
        Edge of a cell [m].
    z_hit, z_random : float
        Share of beams that hit the map, and the density of those that hit anything (share / longest range).
    sigma : float
        Standard deviation of a hit [m].
    max_distance : float
        What is farther from any obstacle, or outside the map, counts as this far [m].

    Returns
    -------
    (k,) array
        By the square of the distance in cells.
    """
    far = min(max_distance, FAR * sigma)
    squares = np.arange(min(math.ceil((far / resolution) ** 2), MOST_SQUARES) + 1)
    distance = np.minimum(resolution * np.sqrt(squares), max_distance)
    distance[-1] = max_distance
    found: NDArray[np.float64] = (z_hit * np.exp(-0.5 * (distance / sigma) ** 2) + z_random) ** 3
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def score_scan(
    particles: NDArray[np.float64],
    beams: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    likelihood: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return a weight for each particle by the likelihood field model.

    The beams of one scan are not independent, so their likelihoods are not multiplied: as in amcl's ``pf`` their
    cubes are summed. (*Probabilistic Robotics*, table 6.3, and ``amcl_laser.cpp``, ``LikelihoodFieldModel``.)

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad] of the robot in the map frame.
    beams : (m, 2) array
        End points of the beams in the robot's frame [m].
    distance : (height, width) array
        From each cell to the nearest occupied one [m]: the root of a whole number of cells, so its square can be looked
        up, and no exponential is taken in the loop.
    resolution : float
        Edge of a cell [m].
    origin : (3,) array
        Pose of the lower-left corner of cell (0, 0) in the map frame [m, m, rad].
    likelihood : (k,) array
        What a beam adds, by the square of the distance in cells; what is farther, or outside the map, adds the last.

    Returns
    -------
    (n,) array
        At least 1; not normalised.
    """
    height, width = distance.shape
    weights = np.empty(particles.shape[0])
    c0, s0 = math.cos(origin[2]), math.sin(origin[2])
    to_square = 1.0 / (resolution * resolution)
    last = likelihood.shape[0] - 1
    for i in range(particles.shape[0]):
        # The particle in the frame of the grid, in cells: then each beam costs one rotation.
        dx, dy = particles[i, 0] - origin[0], particles[i, 1] - origin[1]
        x, y = (c0 * dx + s0 * dy) / resolution, (c0 * dy - s0 * dx) / resolution
        heading = particles[i, 2] - origin[2]
        c, s = math.cos(heading) / resolution, math.sin(heading) / resolution
        weight = 1.0
        for j in range(beams.shape[0]):
            column = math.floor(x + c * beams[j, 0] - s * beams[j, 1])
            row = math.floor(y + s * beams[j, 0] + c * beams[j, 1])
            square = last
            if 0 <= row < height and 0 <= column < width:
                d = float(distance[int(row), int(column)])
                square = min(int(d * d * to_square + 0.5), last)
            weight += likelihood[square]
        weights[i] = weight
    return weights


def warm() -> None:
    """Compile, or load what was compiled."""
    distance = np.zeros((1, 1), dtype=np.float32)
    distance.flags.writeable = False  # as layers of a map are, which all robots share
    score_scan(np.zeros((1, 3)), np.zeros((1, 2)), distance, 0.05, np.zeros(3), np.ones(1))
