"""Bends taken out of a kinematic path: curves that join poses of it at less cost."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.planners.lattice.kernels.driving import Ground
from ppaas.planners.lattice.kernels.reeds_shepp import MOST_PIECES
from ppaas.planners.lattice.kernels.shortcuts import cut, join
from ppaas.planners.lattice.kernels.steering import LEG, Car

Floats = NDArray[np.float64]

PASSES = 3
"""How often at most; each time other poses of the path are tried."""

MOST_POSES = 72
"""Poses of the path that are tried in a pass: the work grows with their square."""

SLICE_POSES = 4
"""Poses from which curves are tried between two checks: some milliseconds."""

WORTH_MORE = 0.995
"""A pass that leaves more than this part of the cost is the last."""


def smooth(ground: Ground, car: Car, legs: Floats, check: Callable[[], None]) -> Floats:
    """Return the (n, LEG) legs of a path that costs no more.

    Parameters
    ----------
    ground : Ground
    car : Car
    legs : (m, LEG) array
        Of the path so far. Those that begin in a blocked cell stay as they are.
    check : callable
        Called every few milliseconds; what it raises ends the work.
    """
    rows, columns = np.floor(legs[:, 1]).astype(np.int64), np.floor(legs[:, 0]).astype(np.int64)
    free = int(np.argmax(ground.costs[rows, columns] < INSCRIBED_INFLATED_OBSTACLE))
    stays, path = legs[:free], legs[free:]
    cost = float(path[:, 5].sum())
    for number in range(PASSES):
        path = _shortened(ground, car, path, number, check)
        before, cost = cost, float(path[:, 5].sum())
        if cost > before * WORTH_MORE:
            break
    return np.concatenate((stays, path))


def _shortened(ground: Ground, car: Car, legs: Floats, number: int, check: Callable[[], None]) -> Floats:
    """Return the legs after one pass."""
    check()
    total = float(np.abs(legs[:, 4]).sum())
    spacing = max(1.0, total / MOST_POSES / 2.0)
    parts = np.empty((len(legs) + int(total / spacing) + 1, LEG))
    legs = parts[: cut(ground, car, legs, spacing, parts)]
    # Among the ends of all parts, one every two spacings; in every second pass those between.
    driven = np.concatenate(([0.0], np.cumsum(np.abs(legs[:, 4]))))
    wanted = np.arange(0.5 * (number % 2), total / (2.0 * spacing), 1.0) * 2.0 * spacing
    picks = np.unique(np.concatenate(([0], np.searchsorted(driven[:-1], wanted), [len(legs)])))
    along = np.concatenate(([0.0], np.cumsum(legs[:, 5])))[picks]
    spots = np.concatenate((legs[:, :3], [_end(legs)]))[picks]
    count = len(picks)
    worths, origins = along.copy(), np.arange(-1, count - 1, dtype=np.int32)
    curves, counts = np.empty((count, MOST_PIECES, LEG)), np.zeros(count, np.int32)
    for first in range(0, count - 1, SLICE_POSES):
        check()
        last = min(first + SLICE_POSES, count - 1)
        join(ground, car, spots, along, worths, origins, curves, counts, first, last)
    chosen = []
    at = count - 1
    while at > 0:
        origin = int(origins[at])
        chosen.append(curves[at, : counts[at]] if counts[at] else legs[picks[origin] : picks[at]])
        at = origin
    return np.concatenate(chosen[::-1]) if chosen else legs


def _end(legs: Floats) -> tuple[float, float, float]:
    """Return x, y, theta where the last leg ends."""
    x, y, theta, curvature, length, _ = legs[-1].tolist()
    turn = curvature * length
    chord = length * float(np.sinc(0.5 * turn / np.pi))
    return x + chord * np.cos(theta + 0.5 * turn), y + chord * np.sin(theta + 0.5 * turn), theta + turn
