"""Kernel: which pieces a robot with a smallest turning radius can drive, and what they cost it.

Units are cells and radians, as in `ppaas.planners.lattice.kernels.driving`.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.lattice.kernels.driving import Ground, drive, level_ground
from ppaas.planners.lattice.kernels.dubins import dubins
from ppaas.planners.lattice.kernels.reeds_shepp import MOST_PIECES, Word, reeds_shepp, spell

Floats = NDArray[np.float64]

LEG = 6
"""Of a leg: x, y, theta where it begins, its curvature, length and cost."""


class Car(NamedTuple):
    """How the robot moves, and what of that costs more.

    ``radius`` of its sharpest turn [cells]; ``backing``: whether it may back up; ``bins`` of headings; what a length
    weighs when backing up (``reverse``), in a turn (``turn``) and in a turn that it was not in just before (plus
    ``change``). A curve to the goal is tried after so many nodes as the distance to it holds ``ratio`` cells, and is
    at most ``longest`` [cells].
    """

    radius: float
    backing: bool
    bins: int
    reverse: float
    turn: float
    change: float
    ratio: float
    longest: float


@njit(cache=True, nogil=True, error_model="numpy")
def weight(car: Car, curvature: float, length: float, before: float) -> float:
    """Return what a length costs on a piece that follows one of the curvature ``before``."""
    gear = car.reverse if length < 0.0 else 1.0
    if curvature == 0.0:
        return gear
    return gear * (car.turn + (car.change if curvature * before <= 0.0 else 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
def curve(car: Car, x: float, y: float, theta: float, to_x: float, to_y: float, to_theta: float) -> Word:
    """Return the cheapest curve from one pose to another, in radii."""
    dx, dy = (to_x - x) / car.radius, (to_y - y) / car.radius
    cosine, sine = math.cos(theta), math.sin(theta)
    ahead, aside = cosine * dx + sine * dy, cosine * dy - sine * dx
    forward = dubins(ahead, aside, to_theta - theta, car.turn)
    if not car.backing:
        return forward
    # Where backing up costs more, one that is none of Reeds and Shepp's may be cheapest: forward, the long way round.
    either = reeds_shepp(ahead, aside, to_theta - theta, car.reverse, car.turn)
    return forward if forward.cost < either.cost else either


@njit(cache=True, nogil=True, error_model="numpy")
def drive_curve(
    ground: Ground, car: Car, x: float, y: float, theta: float, before: float, word: Word, most: float, legs: Floats
) -> tuple[float, int]:
    """Drive along a curve as long as it costs less than ``most``; return what it costs, or infinity, and its legs.

    ``legs`` (``MOST_PIECES``, 6) takes x, y, theta where each of them begins, its curvature, length and cost.
    """
    pieces = np.empty((MOST_PIECES, 2))
    nothing = np.empty((0, 3))
    count = spell(word, pieces)
    total = 0.0
    for piece in range(count):
        curvature, length = pieces[piece, 0] / car.radius, pieces[piece, 1] * car.radius
        reached = drive(ground, x, y, theta, curvature, length, False, nothing)
        cost = reached.cost * weight(car, curvature, length, before)
        total += cost
        if not total < most:
            return math.inf, 0
        legs[piece] = (x, y, theta, curvature, length, cost)
        x, y, theta, before = reached.x, reached.y, reached.theta, curvature
    return total, count


def warm() -> None:
    """Compile and call each kernel once, for robots of both kinds."""
    ground, legs = level_ground(np.zeros((9, 9), np.uint8)), np.empty((MOST_PIECES, LEG))
    for backing in (False, True):
        car = Car(1.0, backing, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
        drive_curve(ground, car, 1.0, 1.0, 0.0, 0.0, curve(car, 1.0, 1.0, 0.0, 5.0, 1.0, 0.0), math.inf, legs)
