"""Bench of the full cost field of a grid, alone and compared with other implementations."""

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
"""Number of fields that are computed with pauses, for each number of threads."""


def grow(costmap: Costmap, goal: Cell, threads: int) -> CostField:
    """Compute the full cost field of a goal."""
    field = CostField(costmap, np.array([goal]), threads=threads)
    field.grow()
    return field


def warm_up(costmap: Costmap, goal: Cell, threads: Sequence[int]) -> int:
    """Compute the field once with each number of threads, as a warm-up; return the number of reached cells."""
    *others, last = threads
    for n in others:
        grow(costmap, goal, n)  # frees its memory for the next one
    return int(np.count_nonzero(np.isfinite(grow(costmap, goal, last).values())))


def uncached(costmap: Costmap) -> Costmap:
    """Return a copy that is new to planners, whose caches are keyed by the costmap object."""
    return Costmap(costmap.data.view(), costmap.info)


def grow_uncached(costmap: Costmap, goal: Cell, threads: int) -> CostField:
    """Compute the field on a copy of the map that is new to the planner."""
    return grow(uncached(costmap), goal, threads)


def farthest(field: CostField) -> Cell:
    """Return the cell with the largest finite cost to the goal."""
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
    """Compute the field repeatedly, with each number of threads and by each peer in turn.

    Parameters
    ----------
    grid : Grid
    goal : (row, column), optional
        A free cell; by default one near the middle.
    threads : sequence of int
    progress : Progress
        Display of the progress.
    runs : int
        Number of runs with each number of threads, after a warm-up that compiles or loads kernels.
    others : dict of Peer, optional
        Other implementations to compare with.

    Returns
    -------
    dict
        ``cells`` and ``reached`` cells; by number of threads the ``seconds`` of the fastest run on a map that is new to
        the planner, ``ns_per_cell`` reached, and ``again_seconds`` of a second field on the same map; the seconds of
        others (``beside``), the reasons why some are ``left_out``, and ``compile_seconds``, which no time includes.

    Raises
    ------
    InvalidParameter
        A number of threads is below 1.
    GoalOutsideMap, GoalOccupied
    """
    if not threads or min(threads) < 1:
        raise InvalidParameter(f"numbers of threads must be 1 or more, not {list(threads)}")
    goal = goal_in(grid.costmap, goal)
    announce(progress, f"field: {grid.name}")
    with compilation() as compiled:
        reached = warm_up(grid.costmap, goal, threads)
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


def with_pauses(grid: Grid, goal: Cell, threads: Sequence[int], pause: float, progress: Progress) -> dict[str, float]:
    """Return the time of fields with pauses between them, as robots plan: with cold caches and sleeping threads.

    Parameters
    ----------
    grid : Grid
    goal : (row, column)
    threads : sequence of int
    pause : float
        Pause between two fields [s].
    progress : Progress

    Returns
    -------
    dict
        Median time of `APART` fields by number of threads, each on a map that is new to the planner [s].
    """
    spent: dict[str, list[float]] = {str(n): [] for n in threads}
    for _ in progress.track(range(APART), description=f"{grid.name}, now and then"):
        for n in threads:
            sleep(pause)
            spent[str(n)].append(timed(partial(grow_uncached, grid.costmap, goal, n))[0])
    return {n: statistics.median(seconds) for n, seconds in spent.items()}


def _ours(costmap: Costmap, goal: Cell, threads: Sequence[int]) -> dict[str, Work]:
    last = costmap

    def first(n: int) -> None:
        nonlocal last
        last = uncached(costmap)
        grow(last, goal, n)

    works: dict[str, Work] = {}
    for n in threads:
        works[str(n)] = lambda n=n: first(n)  # type: ignore[misc]
        works[f"{n} again"] = lambda n=n: grow(last, goal, n)  # type: ignore[misc]
    return works


def _try_others(
    others: Mapping[str, Peer], problem: PeerProblem, progress: Progress
) -> tuple[dict[str, Work], dict[str, float], dict[str, str]]:
    """Return the calls that compute each field, the times of their first runs [s], and why some cannot."""
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
