"""How fast the full field of costs of a grid is computed, by itself and beside others."""

import statistics
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import sleep
from typing import Any

import numpy as np
from rich.progress import Progress

from benchmarks.planners.grids import Grid, goal_in
from benchmarks.planners.peers import Peer, PeerProblem
from benchmarks.planners.timing import BUDGET, RUNS, announce, compilation, cpus, in_turn, timed
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidParameter, PlanningError
from ppaas.planners.ends import Cell
from ppaas.planners.field.cost_field import CostField

Work = Callable[[], object]

APART = 60
"""Fields that are computed now and then with each number of threads."""


def grow(costmap: Costmap, goal: Cell, threads: int) -> CostField:
    """Compute a field from one goal all over the map."""
    field = CostField(costmap, np.array([goal]), threads=threads)
    field.grow()
    return field


def reached_once(costmap: Costmap, goal: Cell, threads: Sequence[int]) -> int:
    """Compute a field once with each number of threads, so that nothing is compiled later; return the cells reached."""
    *others, last = threads
    for n in others:
        grow(costmap, goal, n)  # its memory is the next one's
    return int(np.count_nonzero(np.isfinite(grow(costmap, goal, last).values())))


def newly_read(costmap: Costmap) -> Costmap:
    """Return the same map as planners see it for the first time: they keep what they know of one, not of its copy."""
    return Costmap(costmap.data.view(), costmap.info)


def grow_anew(costmap: Costmap, goal: Cell, threads: int) -> CostField:
    """Compute a field of a map that planners see for the first time."""
    return grow(newly_read(costmap), goal, threads)


def farthest(field: CostField) -> Cell:
    """Return the cell from which it costs most to reach the goal."""
    values = field.values()
    row, column = np.unravel_index(np.argmax(np.where(np.isfinite(values), values, -1.0)), values.shape)
    return int(row), int(column)


def measure(
    grid: Grid,
    goal: Cell | None,
    threads: Sequence[int],
    progress: Progress,
    *,
    runs: int = RUNS,
    others: Mapping[str, Peer] | None = None,
) -> dict[str, Any]:
    """Compute the field again and again, with each number of threads and by each peer in turn.

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
    others : dict of Peer, optional
        To be measured beside ours.

    Returns
    -------
    dict
        ``cells`` in all, ``reached`` ones; by number of threads the ``seconds`` of the fastest run on a map that is
        new to the planner, ``ns_per_cell`` that was reached, and ``again_seconds`` on the same map once more; the
        seconds of others ``beside``, and why some are ``left_out``; the ``compile_seconds`` that are not in any.

    Raises
    ------
    InvalidParameter
        Not from 1 thread up.
    GoalOutsideMap, GoalOccupied
    """
    if not threads or min(threads) < 1:
        raise InvalidParameter(f"a field takes at least one thread, not {list(threads)}")
    goal = goal_in(grid.costmap, goal)
    announce(progress, f"field: {grid.name}")
    with compilation() as compiled:
        reached = reached_once(grid.costmap, goal, threads)
    works, tried, left_out = _try_others(others or {}, PeerProblem(grid.costmap, goal, goal), progress)
    best = in_turn(_ours(grid.costmap, goal, threads) | works, progress, grid.name, runs)
    seconds = {str(n): best[str(n)] for n in threads}
    return {
        "grid": grid.name,
        "cells": grid.costmap.data.size,
        "reached": reached,
        "goal": list(goal),
        "seconds": seconds,
        "ns_per_cell": {n: one / reached * 1e9 for n, one in seconds.items()},
        "again_seconds": {n: best[f"{n} again"] for n in seconds},
        "beside": {name: min(one, best.get(name, one)) for name, one in tried.items()},
        "left_out": left_out,
        "compile_seconds": compiled.seconds,
        "cpus": cpus(),
    }


def now_and_then(grid: Grid, goal: Cell, threads: Sequence[int], pause: float, progress: Progress) -> dict[str, float]:
    """Return what a field takes a while after another, as robots plan: caches are cold by then, and threads asleep.

    Parameters
    ----------
    grid : Grid
    goal : (row, column)
    threads : sequence of int
    pause : float
        Between two fields [s].
    progress : Progress

    Returns
    -------
    dict
        By number of threads the median of `APART` fields, each on a map that is new to the planner [s].
    """
    spent: dict[str, list[float]] = {str(n): [] for n in threads}
    for _ in progress.track(range(APART), description=f"{grid.name}, now and then"):
        for n in threads:
            sleep(pause)
            spent[str(n)].append(timed(partial(grow_anew, grid.costmap, goal, n))[0])
    return {n: statistics.median(seconds) for n, seconds in spent.items()}


def _ours(costmap: Costmap, goal: Cell, threads: Sequence[int]) -> dict[str, Work]:
    last = costmap

    def first(n: int) -> None:
        nonlocal last
        last = newly_read(costmap)
        grow(last, goal, n)

    works: dict[str, Work] = {}
    for n in threads:
        works[str(n)] = lambda n=n: first(n)  # type: ignore[misc]
        works[f"{n} again"] = lambda n=n: grow(last, goal, n)  # type: ignore[misc]
    return works


def _try_others(
    others: Mapping[str, Peer], problem: PeerProblem, progress: Progress
) -> tuple[dict[str, Work], dict[str, float], dict[str, str]]:
    """Return what computes each field, the seconds that it took the first time, and why some cannot."""
    works, tried, left_out = dict[str, Work](), dict[str, float](), dict[str, str]()
    for name, peer in others.items():
        announce(progress, f"  {name}")
        reason = peer.why_not(problem.costmap.data.size)
        try:
            if reason is None:
                work = peer.call(problem)[1]
                tried[name] = timed(work)[0]
                works[name] = work
        except PlanningError as error:
            reason = str(error)
        if reason is not None:
            left_out[name] = reason
    return {name: work for name, work in works.items() if 2.0 * tried[name] < BUDGET}, tried, left_out
