"""Lengths of ways on a map, by the costs that planners compute."""

import math
from collections.abc import Sequence

from ppaas.tasks.assignment import Distance
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Place

COST_OF_CELL = 50.0
"""Cost of a free cell: ``ppaas.planners.weights.NEUTRAL``, which comes with numba."""


def free_length(cost: float, resolution: float) -> float:
    """Return the length of a path through free cells that has a cost [m], on cells of a size [m].

    A path near obstacles costs more than a free one of its length.
    """
    return cost * resolution / COST_OF_CELL


def ways_by(
    starts: Sequence[Place], goals: Sequence[Place], costs: Sequence[Sequence[float | None]], resolution: float
) -> Distance:
    """Return the lengths of the ways of a matrix of costs; between other places, straight lines.

    A way near obstacles counts as longer, by its cost.

    Parameters
    ----------
    starts, goals : sequence of Place
    costs : sequence of sequence of float or None
        A row for each start with the cost to each goal; None where there is no path.
    resolution : float
        Size of a cell of the map [m].
    """
    known: dict[tuple[Place, Place], float] = {
        (start, goal): math.inf if cost is None else free_length(cost, resolution)
        for start, row in zip(starts, costs, strict=True)
        for goal, cost in zip(goals, row, strict=True)
    }
    return lambda start, goal: known.get((start, goal), straight(start, goal))
