"""How fast the full field of costs of a grid is computed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.progress import Progress

from ppaas.clock import monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidParameter
from ppaas.planners.ends import Cell
from ppaas.planners.field import CostField
from robots.bench.planners.grids import Grid, goal_in
from robots.bench.planners.timing import RUNS, compilation, cpus


@dataclass(frozen=True, slots=True)
class Run:
    """One field and the seconds that its two stages took."""

    field: CostField
    setup: float
    growth: float

    @property
    def seconds(self) -> float:
        """Both stages."""
        return self.setup + self.growth


def grow(costmap: Costmap, goal: Cell, threads: int) -> Run:
    """Compute a field from one goal all over the map."""
    began = monotonic()
    field = CostField(costmap, np.array([goal]), threads=threads)
    laid = monotonic()
    field.grow()
    return Run(field, laid - began, monotonic() - laid)


def farthest(field: CostField) -> Cell:
    """Return the cell from which it costs most to reach the goal."""
    values = field.values()
    row, column = np.unravel_index(np.argmax(np.where(np.isfinite(values), values, -1.0)), values.shape)
    return int(row), int(column)


def measure(
    grid: Grid, goal: Cell | None, threads: Sequence[int], progress: Progress, runs: int = RUNS
) -> dict[str, Any]:
    """Compute the field again and again, with each number of threads in turn, so that all see the same machine.

    Parameters
    ----------
    grid : Grid
    goal : (row, column), optional
        A free cell; else one is chosen.
    threads : sequence of int
    progress : Progress
        Is told how far this is.
    runs : int
        With each number of threads; one more, before, compiles the kernels or loads them, and does not count.

    Returns
    -------
    dict
        ``cells`` in all, ``reached`` ones, by number of threads ``seconds`` (the least, made of ``setup_seconds`` and
        ``growth_seconds``) and ``ns_per_cell`` (that was reached), and the ``compile_seconds`` that are not in them.

    Raises
    ------
    InvalidParameter
        Not from 1 thread up.
    GoalOutsideMap, GoalOccupied
    """
    if not threads or min(threads) < 1:
        raise InvalidParameter(f"a field takes at least one thread, not {list(threads)}")
    goal = goal_in(grid.costmap, goal)
    with compilation() as compiled:
        for n in threads:
            first = grow(grid.costmap, goal, n)
    reached = int(np.count_nonzero(np.isfinite(first.field.values())))
    best: dict[int, Run] = {}
    for _ in progress.track(range(runs), description=grid.name):
        for n in threads:
            run = grow(grid.costmap, goal, n)
            if n not in best or run.seconds < best[n].seconds:
                best[n] = run
    return {
        "grid": grid.name,
        "cells": grid.costmap.data.size,
        "reached": reached,
        "goal": list(goal),
        "seconds": {str(n): run.seconds for n, run in best.items()},
        "ns_per_cell": {str(n): run.seconds / reached * 1e9 for n, run in best.items()},
        "setup_seconds": {str(n): run.setup for n, run in best.items()},
        "growth_seconds": {str(n): run.growth for n, run in best.items()},
        "compile_seconds": compiled.seconds,
        "cpus": cpus(),
    }
