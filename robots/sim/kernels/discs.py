"""Kernels: rays that end at discs, and how far a box is from them."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def cast_at_discs(x: float, y: float, headings: Floats, centres: Floats, radius: float) -> Floats:
    """Return the distance to the first of some discs of one radius, by heading.

    Parameters
    ----------
    x, y : float
        Where the rays begin, in none of the discs [m].
    headings : (n,) array
        In the frame of the discs [rad].
    centres : (m, 2) array
        x, y [m].
    radius : float
        Of each disc [m].

    Returns
    -------
    (n,) array
        [m]; infinite where no disc is hit.
    """
    ranges = np.full(headings.size, np.inf)
    for i in range(headings.size):
        cosine, sine = math.cos(headings[i]), math.sin(headings[i])
        for k in range(len(centres)):
            right, up = centres[k, 0] - x, centres[k, 1] - y
            along, beside = cosine * right + sine * up, cosine * up - sine * right
            if along > 0.0 and abs(beside) <= radius:
                ranges[i] = min(ranges[i], along - math.sqrt(radius * radius - beside * beside))
    return ranges


@njit(cache=True, nogil=True, error_model="numpy")
def box_clearance(
    x: float, y: float, theta: float, half_length: float, half_width: float, centres: Floats, radius: float
) -> float:
    """Return the distance from a box at a pose to the nearest disc [m]; negative where they overlap.

    Parameters
    ----------
    x, y, theta : float
        Of the middle of the box [m, rad].
    half_length, half_width : float
        Along and across its heading [m].
    centres : (m, 2) array
        x, y [m].
    radius : float
        Of each disc [m].
    """
    cosine, sine = math.cos(theta), math.sin(theta)
    nearest = np.inf
    for k in range(len(centres)):
        right, up = centres[k, 0] - x, centres[k, 1] - y
        ahead = abs(cosine * right + sine * up) - half_length
        beside = abs(cosine * up - sine * right) - half_width
        outside = math.hypot(max(ahead, 0.0), max(beside, 0.0))
        nearest = min(nearest, outside + min(max(ahead, beside), 0.0))
    return nearest - radius
