"""Kernels: ray casting against discs, and the clearance between a box and discs."""

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


@njit(cache=True, nogil=True, error_model="numpy")
def box_clearance(
    x: float, y: float, theta: float, half_length: float, half_width: float, centres: Floats, radius: float
) -> float:
    """Return the distance from a box at a pose to the nearest disc [m]; negative where they overlap.

    Parameters
    ----------
    x, y, theta : float
        Pose of the centre of the box [m, rad].
    half_length, half_width : float
        Half of its size along and across its heading [m].
    centres : (m, 2) array
        Centres of the discs: x, y [m].
    radius : float
        Radius of all discs [m].
    """
    cosine, sine = math.cos(theta), math.sin(theta)
    nearest = np.inf
    for k in range(len(centres)):
        right, up = centres[k, 0] - x, centres[k, 1] - y
        # Signed distances from the centre of the disc to the sides of the box, in the frame of the box.
        ahead = abs(cosine * right + sine * up) - half_length
        beside = abs(cosine * up - sine * right) - half_width
        outside = math.hypot(max(ahead, 0.0), max(beside, 0.0))
        nearest = min(nearest, outside + min(max(ahead, beside), 0.0))
    return nearest - radius
