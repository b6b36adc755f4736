"""Kernel: ray casting against discs."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def cast_at_discs(x: float, y: float, headings: Floats, centres: Floats, radius: float) -> Floats:
    """Return the distance to the nearest disc along each ray.

    Parameters
    ----------
    x, y : float
        Origin of the rays, outside all discs [m].
    headings : (n,) array
        Directions of the rays, in the frame of the discs [rad].
    centres : (m, 2) array
        Centres of the discs: x, y [m].
    radius : float
        Radius of all discs [m].

    Returns
    -------
    (n,) array
        Distances [m]; infinite where no disc is hit.
    """
    ranges = np.full(headings.size, np.inf)
    for i in range(headings.size):
        cosine, sine = math.cos(headings[i]), math.sin(headings[i])
        for k in range(len(centres)):
            right, up = centres[k, 0] - x, centres[k, 1] - y
            # Centre of the disc in the frame of the ray: the ray enters the disc half a chord before the foot point.
            along, beside = cosine * right + sine * up, cosine * up - sine * right
            if along > 0.0 and abs(beside) <= radius:
                ranges[i] = min(ranges[i], along - math.sqrt(radius * radius - beside * beside))
    return ranges
