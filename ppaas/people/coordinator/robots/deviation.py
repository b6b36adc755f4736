"""Step 1: maximum position deviation of each robot."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = math.sqrt(5.991)
"""Standard deviations that hold 95 % of a Gaussian in the plane (χ² of two degrees of freedom)."""
UNKNOWN = 0.5
"""Deviation of a robot whose covariance is all zeros, which is "unknown" in ROS [m]."""
LEAST = 0.05
"""Least deviation: the width of a cell of usual maps [m]."""


def position_deviation(covariance: NDArray[np.float64]) -> float:
    """Return the distance within which a robot is at its position with 95 % certainty [m].

    Parameters
    ----------
    covariance : (3, 3) array
        Covariance of x, y [m²] and yaw [rad²], of AMCL for example.
    """
    (xx, xy, _), (_, yy, _), _ = covariance.tolist()
    return UNKNOWN if xx == yy == 0.0 else max(radius_of(xx, xy, yy), LEAST)


def radius_of(xx: float, xy: float, yy: float) -> float:
    """Return the radius [m] that holds 95 % of a Gaussian along its widest axis, from its covariance [m²]."""
    widest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
    return CONFIDENCE * math.sqrt(max(widest, 0.0))


def maximum_position_deviation(history: Iterable[float], disagreement: float = 0.0) -> float:
    """Return the maximum position deviation of a robot [m].

    The paper: "maximum position deviation of each robot", from the covariance of AMCL and its history.

    Parameters
    ----------
    history : iterable of float
        Its deviations of the last seconds: the certainty that a filter just regained may be a wrong one [m].
    disagreement : float
        Distance between where it sees people and where other robots see the same people [m].
    """
    return max(max(history, default=UNKNOWN), disagreement)
