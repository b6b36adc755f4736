"""Passes: the times that the robot came by a place, after it was elsewhere."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.submaps import travelled
from ppaas.planar_poses import PoseArray, relative


def mileage(poses: PoseArray) -> NDArray[np.float64]:
    """Return the distance (k,) travelled at each key frame, turns included [m].

    Where key frames between have been removed, it is less than the robot drove: passes then count as one.
    """
    steps = relative(poses[:-1], poses[1:])
    return np.concatenate(([0.0], np.cumsum(travelled(steps))))


def divided_passes(mileages: NDArray[np.float64], apart: float) -> NDArray[np.int64]:
    """Return the number (n,) of the pass of each key frame near a place, 0 for the first.

    Parameters
    ----------
    mileages : (n,) array
        Of key frames near a place, ascending [m].
    apart : float
        Least distance travelled between two passes [m].
    """
    return np.concatenate(([0], np.cumsum(np.diff(mileages) >= apart))).astype(np.int64)
