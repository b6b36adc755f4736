"""Kernel: likelihood of a scan from each particle by the beam model, with rays cast through the map.

*Probabilistic Robotics*, 6.3, table 6.1, with the sum of cubes of amcl (``amcl_laser.cpp``).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.localization.kernels.sight import cast
from ppaas.maps.kernels.serial import serial_copy


class BeamShares(NamedTuple):
    """Mixture of a measured range (*Probabilistic Robotics*, table 6.1).

    Parameters
    ----------
    hit, short, max, rand : float
        Weights of hits, of unexpected obstacles, of ranges without a hit, and of random ranges.
    sigma_hit : float
        Standard deviation of a hit [m].
    lambda_short : float
        Rate of the exponential distribution of unexpected obstacles [1/m].
    """

    hit: float
    short: float
    max: float
    rand: float
    sigma_hit: float
    lambda_short: float


Score = Callable[
    [NDArray[np.float64], NDArray[np.float64], NDArray[np.float32], float, NDArray[np.float64], BeamShares, float],
    NDArray[np.float64],
]


@compiled
def _likelihood(measured: float, expected: float, range_max: float, shares: BeamShares) -> float:
    """Return the likelihood of a range, given the range cast in the map (table 6.1)."""
    off = measured - expected
    # 1. Correct range with measurement noise.
    p = shares.hit * math.exp(-0.5 * (off / shares.sigma_hit) ** 2)
    # 2. Unexpected obstacle in front of the expected one.
    if off < 0.0:
        p += shares.short * shares.lambda_short * math.exp(-shares.lambda_short * measured)
    # 3. No hit, or 4. random measurement.
    if measured >= range_max:
        return p + shares.max
    return p + shares.rand / range_max


def _score_ranges(
    particles: NDArray[np.float64],
    beams: NDArray[np.float64],
    distance: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    shares: BeamShares,
    range_max: float,
) -> NDArray[np.float64]:
    """Return the sum of the cubed likelihoods of the beams for each particle (``amcl_laser.cpp``, ``BeamModel``).

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad] of the robot in the map frame.
    beams : (m, 4) array
        x, y [m] of the laser and direction [rad] of each beam in the robot's frame, and its range [m], ``range_max``
        without a hit.
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied one [m].
    resolution : float
        Edge of a cell [m].
    origin : (3,) array
        Pose of the lower-left corner of cell (0, 0) in the map frame [m, m, rad].
    shares : BeamShares
        Mixture of the model.
    range_max : float
        Longest range of the laser [m].

    Returns
    -------
    (n,) array
        Independent of the number of threads.
    """
    c0, s0 = math.cos(origin[2]), math.sin(origin[2])
    sums = np.empty(particles.shape[0])
    for i in prange(particles.shape[0]):
        c, s = math.cos(particles[i, 2]), math.sin(particles[i, 2])
        total = 0.0
        for j in range(beams.shape[0]):
            # Pose of the beam in the frame of the grid, in cells.
            px = particles[i, 0] + c * beams[j, 0] - s * beams[j, 1] - origin[0]
            py = particles[i, 1] + s * beams[j, 0] + c * beams[j, 1] - origin[1]
            angle = particles[i, 2] + beams[j, 2] - origin[2]
            x, y = (c0 * px + s0 * py) / resolution, (c0 * py - s0 * px) / resolution
            cells = cast(distance, x, y, math.cos(angle), math.sin(angle), range_max / resolution, resolution)
            total += _likelihood(beams[j, 3], cells * resolution, range_max, shares) ** 3
        sums[i] = total
    return sums


score_parallel: Score = compiled(parallel=True)(_score_ranges)
score_serial: Score = compiled(serial_copy(_score_ranges))


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    distance = np.zeros((1, 1), dtype=np.float32)
    distance.flags.writeable = False  # like the layers of a map, which all robots share
    shares = BeamShares(0.95, 0.1, 0.05, 0.05, 0.2, 0.1)
    for score in (score_serial, score_parallel):
        score(np.zeros((1, 3)), np.ones((1, 4)), distance, 0.05, np.zeros(3), shares, 8.0)
