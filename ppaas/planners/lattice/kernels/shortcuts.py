"""Kernel: make a path of arcs and straight pieces cheaper by curves that leave out what is between two of its poses.

Which poses to join is a cheapest path itself, from the first to the last: each may be left along the old path or by a
curve to any later one.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.lattice.kernels.driving import Ground, drive, level_ground, looks
from ppaas.planners.lattice.kernels.reeds_shepp import MOST_PIECES
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve, drive_curve, weight

Floats = NDArray[np.float64]
Counts = NDArray[np.int32]

GAIN = 1e-6
"""A curve that is not cheaper by so much is no shortcut."""


@njit(cache=True, nogil=True, error_model="numpy")
def join(
    ground: Ground, car: Car, spots: Floats, along: Floats, worths: Floats, origins: Counts, legs: Floats,
    counts: Counts, first: int, last: int,
) -> None:  # fmt: skip
    """Try the curves from some poses to all later ones.

    Parameters
    ----------
    ground : Ground
    car : Car
    spots : (n, 3) array
        The poses: x, y, theta.
    along, worths : (n,) array
        What it costs to get to each on the old path, and at best so far; the same at first.
    origins : (n,) int32 array
        The pose from which it is best reached.
    legs, counts : (n, MOST_PIECES, LEG) and (n,) int32 array
        The curve from there; with a count of 0 it is the old path.
    first, last : int
        From which poses, ``last`` excluded; each after all poses before it.
    """
    trial = np.empty((MOST_PIECES, LEG))
    for at in range(first, last):
        x, y, theta = spots[at]
        old = worths[at] + along[at + 1] - along[at]
        if old < worths[at + 1]:
            worths[at + 1], origins[at + 1], counts[at + 1] = old, at, 0
        for to in range(at + 1, len(spots)):
            most = worths[to] - worths[at] - GAIN
            if math.hypot(spots[to, 0] - x, spots[to, 1] - y) * ground.rates[0] >= most:
                continue
            word = curve(car, x, y, theta, spots[to, 0], spots[to, 1], spots[to, 2])
            if word.cost * car.radius * ground.rates[0] >= most:
                continue
            cost, count = drive_curve(ground, car, x, y, theta, 0.0, word, most, trial)
            if count:
                worths[to], origins[to], counts[to] = worths[at] + cost, at, count
                legs[to] = trial


@njit(cache=True, nogil=True, error_model="numpy")
def cut(ground: Ground, car: Car, legs: Floats, longest: float, parts: Floats) -> int:
    """Cut long legs where points of them were looked at, and return how many parts they are.

    Parameters
    ----------
    ground : Ground
    car : Car
    legs : (n, LEG) array
        Of a robot that stands free.
    longest : float
        No part is much longer [cells].
    parts : (m, LEG) array
        Out: the parts of all legs, in order; n + total length / ``longest`` rows are enough.
    """
    count = 0
    nothing = np.empty((0, 3))
    for leg in range(len(legs)):
        x, y, theta, curvature, length, _ = legs[leg]
        points = looks(ground, curvature, length)
        pieces = min(points, int(abs(length) / longest) + 1)
        first, begin = 0, count
        for piece in range(pieces):
            last = points * (piece + 1) // pieces
            part = length * (last - first) / points
            reached = drive(ground, x, y, theta, curvature, part, False, nothing)
            if reached.cost == math.inf:  # rounding brought a point over the edge of its cell: leave the leg whole
                parts[begin] = legs[leg]
                count = begin + 1
                break
            parts[count] = (x, y, theta, curvature, part, reached.cost * weight(car, curvature, part, curvature))
            x, y, theta = reached.x, reached.y, reached.theta
            first = last
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def trace(ground: Ground, legs: Floats, leaving: bool, points: Floats) -> int:
    """Write the points that are looked at along some legs, and return how many they are.

    Parameters
    ----------
    ground : Ground
    legs : (n, LEG) array
    leaving : bool
        Whether the robot stands in a blocked cell where the first begins.
    points : (m, 3) array
        Out: x, y, theta, without where the first leg begins.
    """
    count = 0
    for leg in range(len(legs)):
        x, y, theta, curvature, length, _ = legs[leg]
        reached = drive(ground, x, y, theta, curvature, length, leaving, points[count:])
        leaving = reached.leaving
        count += looks(ground, curvature, length)
    return count


def warm() -> None:
    """Compile and call each kernel once."""
    ground, car = level_ground(np.zeros((9, 9), np.uint8)), Car(1.0, True, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
    legs = np.array([[1.0, 1.0, 0.0, 0.0, 2.0, 2.0]])
    cut(ground, car, legs, 1.0, np.empty((4, LEG)))
    trace(ground, legs, False, np.empty((9, 3)))
    spots, along = np.array([[1.0, 1.0, 0.0], [3.0, 1.0, 0.0]]), np.array([0.0, 2.0])
    counts = np.zeros(2, np.int32)
    join(ground, car, spots, along, along.copy(), counts.copy(), np.empty((2, MOST_PIECES, LEG)), counts, 0, 1)
