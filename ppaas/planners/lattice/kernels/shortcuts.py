"""Kernel: shortcuts of a path of arcs and straight pieces, by curves between two of its poses.

The best set of shortcuts is a shortest path in an acyclic graph, found by dynamic programming: its nodes are poses of
the path; its edges are the old path to the next pose, and a curve to each later pose.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.lattice.kernels.driving import DrivingSurface, drive, flat_surface, sample_count
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve, drive_curve, weight

Floats = NDArray[np.float64]
Counts = NDArray[np.int32]

GAIN = 1e-6
"""Least saving of a shortcut [cells of cost]."""


@compiled
def join(
    surface: DrivingSurface, car: Car, poses: Floats, along: Floats, costs: Floats, origins: Counts, legs: Floats,
    counts: Counts, first: int, last: int,
) -> None:  # fmt: skip
    """Try the curves from poses ``first`` to ``last`` to all later ones, and update the best costs.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    poses : (n, 3) float64 array
        x, y, theta [cells, rad].
    along : (n,) float64 array
        Cost of each pose along the old path.
    costs : (n,) float64 array
        Least cost of each pose so far; equal to ``along`` at first. In and out.
    origins : (n,) int32 array
        Predecessor of each pose on its best path. In and out.
    legs : (n, MAX_PIECES, LEG) float64 array
        Legs of the curve from the predecessor. In and out.
    counts : (n,) int32 array
        Number of legs of that curve; 0 if the old path is best. In and out.
    first, last : int
        Range of poses, ``last`` excluded. All poses before ``first`` must have been done.
    """
    trial = np.empty((MAX_PIECES, LEG))
    for at in range(first, last):
        x, y, theta = poses[at]
        old = costs[at] + along[at + 1] - along[at]
        if old < costs[at + 1]:
            costs[at + 1], origins[at + 1], counts[at + 1] = old, at, 0
        for to in range(at + 1, len(poses)):
            most = costs[to] - costs[at] - GAIN
            if math.hypot(poses[to, 0] - x, poses[to, 1] - y) * surface.rates[0] >= most:
                continue
            word = curve(car, x, y, theta, poses[to, 0], poses[to, 1], poses[to, 2])
            if word.cost * car.radius * surface.rates[0] >= most:
                continue
            cost, count = drive_curve(surface, car, x, y, theta, 0.0, word, most, trial)
            if count:
                costs[to], origins[to], counts[to] = costs[at] + cost, at, count
                legs[to] = trial


@compiled
def cut(surface: DrivingSurface, car: Car, legs: Floats, longest: float, parts: Floats) -> int:
    """Divide long legs at their samples, and return the number of parts.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    legs : (n, LEG) float64 array
        Legs; the robot must be free at the begin of the first.
    longest : float
        Approximate maximum length of a part [cells].
    parts : (m, LEG) float64 array
        Out: the parts of all legs, in order; n + total length / ``longest`` rows suffice.
    """
    count = 0
    nothing = np.empty((0, 3))
    for leg in range(len(legs)):
        x, y, theta, curvature, length, _ = legs[leg]
        points = sample_count(surface, curvature, length)
        pieces = min(points, int(abs(length) / longest) + 1)
        first, begin = 0, count
        for piece in range(pieces):
            last = points * (piece + 1) // pieces
            part = length * (last - first) / points
            reached = drive(surface, x, y, theta, curvature, part, False, nothing)
            if reached.cost == math.inf:  # rounding moved a sample across a cell border: keep the leg whole
                parts[begin] = legs[leg]
                count = begin + 1
                break
            parts[count] = (x, y, theta, curvature, part, reached.cost * weight(car, curvature, part, curvature))
            x, y, theta = reached.x, reached.y, reached.theta
            first = last
            count += 1
    return count


@compiled
def trace(surface: DrivingSurface, legs: Floats, leaving: bool, points: Floats) -> int:
    """Write the samples along legs, and return their number.

    Parameters
    ----------
    surface : DrivingSurface
    legs : (n, LEG) float64 array
    leaving : bool
        Whether the robot is in a blocked cell at the begin of the first leg.
    points : (m, 3) float64 array
        Out: x, y, theta of the samples, without the begin of the first leg.
    """
    count = 0
    for leg in range(len(legs)):
        x, y, theta, curvature, length, _ = legs[leg]
        reached = drive(surface, x, y, theta, curvature, length, leaving, points[count:])
        leaving = reached.leaving
        count += sample_count(surface, curvature, length)
    return count


def warm() -> None:
    """Compile and call each kernel once."""
    surface, car = flat_surface(np.zeros((9, 9), np.uint8)), Car(1.0, True, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
    legs = np.array([[1.0, 1.0, 0.0, 0.0, 2.0, 2.0]])
    cut(surface, car, legs, 1.0, np.empty((4, LEG)))
    trace(surface, legs, False, np.empty((9, 3)))
    poses, along = np.array([[1.0, 1.0, 0.0], [3.0, 1.0, 0.0]]), np.array([0.0, 2.0])
    counts = np.zeros(2, np.int32)
    join(surface, car, poses, along, along.copy(), counts.copy(), np.empty((2, MAX_PIECES, LEG)), counts, 0, 1)
