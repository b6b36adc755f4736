"""Smoothing of a kinematic path: shortcuts by curves that connect two of its poses at less cost."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.planners.lattice.kernels.driving import DrivingSurface
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES
from ppaas.planners.lattice.kernels.shortcuts import cut, join
from ppaas.planners.lattice.kernels.steering import LEG, Car

Floats = NDArray[np.float64]

PASSES = 3
"""Maximum number of passes; each tries other poses of the path."""

MAX_POSES = 72
"""Maximum number of poses tried in a pass: the work grows with their square."""

SLICE_POSES = 4
"""Poses from which curves are tried between two checks: a few milliseconds."""

LAST_PASS_RATIO = 0.995
"""A pass that reduces the cost to no less than this fraction is the last."""


def smooth(surface: DrivingSurface, car: Car, legs: Floats, check: Callable[[], None]) -> Floats:
    """Return the (n, LEG) legs of a path that costs no more.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    legs : (m, LEG) array
        Legs of the path. Those that begin in a blocked cell are not changed.
    check : callable
        Called every few milliseconds; an exception from it ends the work.
    """
    rows, columns = np.floor(legs[:, 1]).astype(np.int64), np.floor(legs[:, 0]).astype(np.int64)
    free = int(np.argmax(surface.costs[rows, columns] < INSCRIBED_INFLATED_OBSTACLE))
    unchanged, path = legs[:free], legs[free:]
    cost = float(path[:, 5].sum())
    for number in range(PASSES):
        path = _shortened(surface, car, path, number, check)
        before, cost = cost, float(path[:, 5].sum())
        if cost > before * LAST_PASS_RATIO:
            break
    return np.concatenate((unchanged, path))


def _shortened(surface: DrivingSurface, car: Car, legs: Floats, number: int, check: Callable[[], None]) -> Floats:
    """Return the legs after one pass."""
    check()
    total = float(np.abs(legs[:, 4]).sum())
    spacing = max(1.0, total / MAX_POSES / 2.0)
    parts = np.empty((len(legs) + int(total / spacing) + 1, LEG))
    legs = parts[: cut(surface, car, legs, spacing, parts)]
    # Pick one end of a part every two spacings; odd passes pick those in between.
    driven = np.concatenate(([0.0], np.cumsum(np.abs(legs[:, 4]))))
    wanted = np.arange(0.5 * (number % 2), total / (2.0 * spacing), 1.0) * 2.0 * spacing
    picks = np.unique(np.concatenate(([0], np.searchsorted(driven[:-1], wanted), [len(legs)])))
    along = np.concatenate(([0.0], np.cumsum(legs[:, 5])))[picks]
    poses = np.concatenate((legs[:, :3], [_end(legs)]))[picks]
    count = len(picks)
    costs, origins = along.copy(), np.arange(-1, count - 1, dtype=np.int32)
    curves, counts = np.empty((count, MAX_PIECES, LEG)), np.zeros(count, np.int32)
    for first in range(0, count - 1, SLICE_POSES):
        check()
        last = min(first + SLICE_POSES, count - 1)
        join(surface, car, poses, along, costs, origins, curves, counts, first, last)
    chosen = []
    at = count - 1
    while at > 0:
        origin = int(origins[at])
        chosen.append(curves[at, : counts[at]] if counts[at] else legs[picks[origin] : picks[at]])
        at = origin
    return np.concatenate(chosen[::-1]) if chosen else legs


def _end(legs: Floats) -> tuple[float, float, float]:
    """Return x, y, theta at the end of the last leg."""
    x, y, theta, curvature, length, _ = legs[-1].tolist()
    turn = curvature * length
    chord = length * float(np.sinc(0.5 * turn / np.pi))
    return x + chord * np.cos(theta + 0.5 * turn), y + chord * np.sin(theta + 0.5 * turn), theta + turn
