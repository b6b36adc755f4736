"""Kernel: curves that a robot with a minimum turning radius can drive, and their costs.

Units are cells and radians, as in `ppaas.planners.lattice.kernels.driving`.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.lattice.kernels.driving import DrivingSurface, drive, flat_surface
from ppaas.planners.lattice.kernels.dubins import dubins
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES, CurveWord, reeds_shepp, spell

Floats = NDArray[np.float64]

LEG = 6
"""Columns of a leg: x, y, theta at its begin [cells, rad], curvature [1/cell], length [cells], cost."""


class Car(NamedTuple):
    """Kinematics of the robot, and the weights of its motions.

    Attributes
    ----------
    radius : float
        Minimum turning radius [cells].
    backing : bool
        Whether the robot may drive in reverse.
    bins : int
        Number of heading bins.
    reverse, turn : float
        Factors on the length driven in reverse, and in a turn.
    change : float
        Added to ``turn`` where the turn follows a straight piece or a turn to the other side.
    ratio : float
        Number of expansions between two analytic curves to the goal: its distance [cells] / ``ratio``.
    longest : float
        Maximum length of the analytic curve to the goal [cells].
    """

    radius: float
    backing: bool
    bins: int
    reverse: float
    turn: float
    change: float
    ratio: float
    longest: float


@compiled
def weight(car: Car, curvature: float, length: float, before: float) -> float:
    """Return the factor on the length of a piece that follows one of the curvature ``before``."""
    gear = car.reverse if length < 0.0 else 1.0
    if curvature == 0.0:
        return gear
    return gear * (car.turn + (car.change if curvature * before <= 0.0 else 0.0))


@compiled
def curve(car: Car, x: float, y: float, theta: float, to_x: float, to_y: float, to_theta: float) -> CurveWord:
    """Return the cheapest curve from one pose to another, ignoring obstacles; lengths in radii."""
    dx, dy = (to_x - x) / car.radius, (to_y - y) / car.radius
    cosine, sine = math.cos(theta), math.sin(theta)
    ahead, aside = cosine * dx + sine * dy, cosine * dy - sine * dx
    forward = dubins(ahead, aside, to_theta - theta, car.turn)
    if not car.backing:
        return forward
    # Reeds-Shepp words are the shortest curves. If reverse costs more, a forward-only Dubins curve may be cheaper.
    either = reeds_shepp(ahead, aside, to_theta - theta, car.reverse, car.turn)
    return forward if forward.cost < either.cost else either


@compiled
def drive_curve(
    surface: DrivingSurface,
    car: Car,
    x: float,
    y: float,
    theta: float,
    before: float,
    word: CurveWord,
    most: float,
    legs: Floats,
) -> tuple[float, int]:
    """Drive along a curve, and return its cost and number of legs.

    If it collides, or costs ``most`` or more, the result is infinity and 0.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    x, y, theta : float
        Pose at the begin [cells, rad].
    before : float
        Curvature of the piece before [1/cell].
    word : CurveWord
    most : float
        Cost limit.
    legs : (MAX_PIECES, LEG) float64 array
        Out: the legs of the curve.
    """
    pieces = np.empty((MAX_PIECES, 2))
    nothing = np.empty((0, 3))
    count = spell(word, pieces)
    total = 0.0
    for piece in range(count):
        curvature, length = pieces[piece, 0] / car.radius, pieces[piece, 1] * car.radius
        reached = drive(surface, x, y, theta, curvature, length, False, nothing)
        cost = reached.cost * weight(car, curvature, length, before)
        total += cost
        if not total < most:
            return math.inf, 0
        legs[piece] = (x, y, theta, curvature, length, cost)
        x, y, theta, before = reached.x, reached.y, reached.theta, curvature
    return total, count


def warm() -> None:
    """Compile and call each kernel once, for both motion models."""
    surface, legs = flat_surface(np.zeros((9, 9), np.uint8)), np.empty((MAX_PIECES, LEG))
    for backing in (False, True):
        car = Car(1.0, backing, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
        drive_curve(surface, car, 1.0, 1.0, 0.0, 0.0, curve(car, 1.0, 1.0, 0.0, 5.0, 1.0, 0.0), math.inf, legs)
