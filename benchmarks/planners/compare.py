"""Comparison of our planners with installed peers, on the same grid and problem in one run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.planners import scenario
from benchmarks.planners.field import farthest, grow, grow_uncached
from benchmarks.planners.grids import Grid, goal_in
from benchmarks.planners.peers import BESIDE, NAVFN, PATHS, Peer, PeerProblem
from benchmarks.planners.timing import announce, cpus, least, on_threads, within
from ppaas.errors import InvalidPlanner, NotFound, PlanningError, PlanTimeout
from ppaas.planners import create, planner_names
from ppaas.planners.ends import Cell
from ppaas.planners.path import path_cost

OURS = ("dijkstra", "astar", "jps", "hub_labels")
"""Our planners that compute the long path, if they are installed."""

RIGHT = 1e-4
"""Largest relative error of a right answer."""

PATIENCE = 8.0
"""Time limit of a planner to prepare the map [s]."""

PACKAGES = tuple(dict.fromkeys((*BESIDE, *(peer.package for peer in PATHS))))

Row = dict[str, Any]
Reasons = dict[str, str]


def measure(
    grid: Grid, goal: Cell | None, threads: Sequence[int], only: Sequence[str], progress: Progress
) -> dict[str, Any]:
    """Compute the full field and one long path by all planners and peers.

    Parameters
    ----------
    grid : Grid
    goal : (row, column), optional
        A free cell; by default one near the middle. The path starts at the cell with the largest cost to it.
    threads : sequence of int
        Numbers of threads of our field.
    only : sequence of str
        Packages of peers, or navfn; empty for all.
    progress : Progress
        Display of the progress.

    Raises
    ------
    NotFound
        A peer is unknown.
    GoalOutsideMap, GoalOccupied

    Returns
    -------
    dict
        ``fields`` and ``paths``: rows with the implementation (``who``), the problem that it ``solves``, ``seconds``,
        the ``ratio`` to ours, and the error; the reasons why some are ``left_out``; and the problem.
    """
    for package in only:
        if package not in PACKAGES:
            raise NotFound("peer", package, PACKAGES)
    goal = goal_in(grid.costmap, goal)
    announce(progress, f"comparison: {grid.name}")
    field = grow(grid.costmap, goal, max(threads))
    exact = field.values()
    problem = PeerProblem(grid.costmap, goal, farthest(field))
    cheapest = path_cost(grid.costmap, field.path_from(problem.start))
    del field  # frees its memory for the timed fields
    work = {
        "fields": _our_fields(problem, threads) + _field_steps(problem, exact, only),
        "paths": _our_path_steps(problem, cheapest) + _path_steps(problem, cheapest, only),
    }
    rows, left_out = _work_off(work, progress)
    return {
        "grid": grid.name,
        "cells": exact.size,
        "reached": int(np.isfinite(exact).sum()),
        "goal": list(goal),
        "start": list(problem.start),
        **rows,
        "left_out": left_out,
        "cpus": cpus(),
    }


@dataclass(frozen=True, slots=True)
class _Step:
    """A measurement: its name, and the function that returns its row, or the reason why it cannot run."""

    name: str
    row: Callable[[], Row]
    why_not: str | None = None


def _work_off(work: Mapping[str, Sequence[_Step]], progress: Progress) -> tuple[dict[str, list[Row]], Reasons]:
    """Run the steps; return the rows by kind, and the reasons why some are left out."""
    told, left_out = dict[str, list[Row]](), dict[str, str]()
    task = progress.add_task("", total=sum(len(steps) for steps in work.values()))
    for kind, steps in work.items():
        told[kind] = []
        for step in steps:
            progress.update(task, advance=1, description=step.name)
            announce(progress, f"  {step.name}")
            reason = step.why_not or _add_row(told[kind], step)
            if reason is not None:
                left_out[step.name] = reason
        _add_ratios(told[kind])
    progress.remove_task(task)
    return told, left_out


def _add_row(rows: list[Row], step: _Step) -> str | None:
    """Run a step and add its row, or return the reason why it failed."""
    try:
        rows.append(step.row())
    except PlanningError as error:
        return str(error)
    return None


def _add_ratios(rows: list[Row]) -> None:
    """Add the ratio of each time to that of our fastest planner with the right answer."""
    ours = min(row["seconds"] for row in rows if row["ours"] and row["off"] < RIGHT)
    for row in rows:
        row["ratio"] = row["seconds"] / ours


# -- fields ------------------------------------------------------------------------------------------------------------


def _our_fields(problem: PeerProblem, threads: Sequence[int]) -> list[_Step]:
    return [_Step(f"dijkstra, {on_threads(n)}", partial(_our_field_row, problem, n)) for n in threads]


def _our_field_row(problem: PeerProblem, threads: int) -> Row:
    costmap, goal = problem.costmap, problem.goal
    seconds, field = least(partial(grow_uncached, costmap, goal, threads))
    reached = int(np.isfinite(field.values()).sum())
    who = f"ppaas dijkstra, {on_threads(threads)}"
    told = {"who": who, "ours": True, "solves": "the definition", "seconds": seconds, "prepare_seconds": 0.0}
    return {**told, "ns_per_cell": seconds / reached * 1e9, "off": 0.0, "other_cells": 0}


def _field_steps(problem: PeerProblem, exact: NDArray[np.float64], only: Sequence[str]) -> list[_Step]:
    peers = [peer for name, peer in BESIDE.items() if name == "navfn" or not only or name in only]
    return [
        _Step(f"{peer.package} {peer.name}", partial(_field_row, peer, problem, exact), peer.why_not(exact.size))
        for peer in peers
    ]


def _field_row(peer: Peer, problem: PeerProblem, exact: NDArray[np.float64]) -> Row:
    prepare_seconds, call = peer.call(problem)
    seconds, found = least(call)
    field = peer.told(found, problem)
    ours, theirs = np.isfinite(exact), np.isfinite(field)
    both = ours & theirs & (exact > 0.0)
    return {
        **_who(peer),
        "seconds": seconds,
        "ns_per_cell": seconds / int(theirs.sum()) * 1e9,
        "prepare_seconds": prepare_seconds,
        "off": float((np.abs(field[both] - exact[both]) / exact[both]).mean()) if both.any() else 0.0,
        "other_cells": int((ours != theirs).sum()),
    }


# -- one path ----------------------------------------------------------------------------------------------------------


def _our_path_steps(problem: PeerProblem, cheapest: float) -> list[_Step]:
    names = [name for name in OURS if name in planner_names()]
    return [_Step(f"ppaas {name}", partial(_our_path_row, name, problem, cheapest)) for name in names]


def _our_path_row(name: str, problem: PeerProblem, cheapest: float) -> Row:
    planner = create(name)
    scenario.warm(planner)
    try:
        asked = scenario.on_map(planner, problem.costmap, check=within(PATIENCE))
    except PlanTimeout as error:
        raise InvalidPlanner(f"its index takes longer than {PATIENCE:g} s") from error
    question = asked.question(*problem.start, *problem.goal)
    seconds, cells = least(lambda: scenario.answer(question))
    row = {"who": f"ppaas {name}", "ours": True, "solves": planner.purpose, "seconds": seconds}
    return {**row, "prepare_seconds": asked.index_seconds, **_judged(problem, cells, cheapest)}


def _path_steps(problem: PeerProblem, cheapest: float, only: Sequence[str]) -> list[_Step]:
    size = problem.costmap.data.size
    return [
        _Step(f"{peer.package} {peer.name}", partial(_path_row, peer, problem, cheapest), peer.why_not(size))
        for peer in PATHS
        if not only or peer.package in only
    ]


def _path_row(peer: Peer, problem: PeerProblem, cheapest: float) -> Row:
    prepare_seconds, call = peer.call(problem)
    seconds, found = least(call)
    row = {**_who(peer), "seconds": seconds, "prepare_seconds": prepare_seconds}
    return {**row, **_judged(problem, peer.told(found, problem), cheapest)}


def _judged(problem: PeerProblem, cells: NDArray[np.integer], cheapest: float) -> Row:
    """Return the relative excess cost of a path over the cheapest, and whether a robot could follow it."""
    length = scenario.walked(problem.free(), cells, [*problem.start, *problem.goal])
    cost = path_cost(problem.costmap, cells.astype(np.int32)) if len(cells) else float("nan")
    return {
        "cells": len(cells),
        "off": cost / cheapest - 1.0 if cheapest else 0.0,
        "walkable": bool(np.isfinite(length)),
    }


def _who(peer: Peer) -> Row:
    if peer is NAVFN:
        return {"who": "ppaas navfn, 1 thread", "ours": False, "solves": peer.solves}
    return {"who": f"{peer.package} {peer.installed} {peer.name}", "ours": False, "solves": peer.solves}
