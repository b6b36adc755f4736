"""The same grid and the same problem, ours beside the peers that are installed, in one run."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from ppaas.errors import NotFound
from ppaas.planners import create, planner_names
from ppaas.planners.ends import Cell
from ppaas.planners.path import path_cost
from robots.bench.planners import scenario
from robots.bench.planners.field import farthest, grow
from robots.bench.planners.grids import Grid, goal_in
from robots.bench.planners.peers import FIELDS, PATHS, Peer, Problem
from robots.bench.planners.timing import cpus, least

OURS = ("dijkstra", "astar", "jps", "hub_labels")
"""Planners asked for one long path, of those that are installed."""

BUDGET = 6.0
"""Seconds after which something slow is not run again."""

PEERS = tuple(dict.fromkeys(peer.package for peer in (*FIELDS, *PATHS)))

Row = dict[str, Any]


def measure(
    grid: Grid, goal: Cell | None, threads: Sequence[int], only: Sequence[str], progress: Progress
) -> dict[str, Any]:
    """Compute the full field, and one long path, by all.

    Parameters
    ----------
    grid : Grid
    goal : (row, column), optional
        A free cell; else one is chosen. The path begins where it costs most to come from.
    threads : sequence of int
        Numbers of threads of our field.
    only : sequence of str
        Packages of peers; none of them means all.
    progress : Progress
        Is told how far this is.

    Raises
    ------
    NotFound
        No such peer.
    GoalOutsideMap, GoalOccupied

    Returns
    -------
    dict
        ``fields`` and ``paths``: rows with ``who``, what it ``solves``, ``seconds``, the ``ratio`` to ours, and how far
        from the exact answer it is; peers that are ``missing`` or that it is
        ``too_large_for``; what the problem is.
    """
    for package in only:
        if package not in PEERS:
            raise NotFound("peer", package, PEERS)
    goal = goal_in(grid.costmap, goal)
    field = grow(grid.costmap, goal, max(threads)).field
    exact = field.values()
    reached = np.isfinite(exact)
    problem = Problem(grid.costmap, goal, farthest(field))
    cheapest = path_cost(grid.costmap, field.path_from(problem.start))
    fields, paths = ([peer for peer in peers if not only or peer.package in only] for peers in (FIELDS, PATHS))
    work = [(_field_row, exact, fields), (_path_row, cheapest, paths)]
    task = progress.add_task("ours", total=1 + len(fields) + len(paths))
    rows = [_our_fields(problem, threads), _our_paths(problem, cheapest)]
    for told, (row_of, right, peers) in zip(rows, work, strict=True):
        for peer in peers:
            progress.update(task, advance=1, description=f"{peer.package} {peer.name}")
            if peer.installed and peer.may(exact.size):
                told.append(row_of(peer, problem, right))  # type: ignore[operator]
        _add_ratios(told)
    progress.remove_task(task)
    return {
        "grid": grid.name,
        "cells": exact.size,
        "reached": int(reached.sum()),
        "goal": list(goal),
        "start": list(problem.start),
        "fields": rows[0],
        "paths": rows[1],
        "missing": sorted({peer.package for peer in (*fields, *paths) if not peer.installed}),
        "too_large_for": sorted({peer.package for peer in (*fields, *paths) if not peer.may(exact.size)}),
        "cpus": cpus(),
    }


def _add_ratios(rows: list[Row]) -> None:
    """Say how many times longer than the fastest of ours each takes."""
    ours = min(row["seconds"] for row in rows if row["ours"])
    for row in rows:
        row["ratio"] = row["seconds"] / ours


# -- fields ------------------------------------------------------------------------------------------------------------


def _our_fields(problem: Problem, threads: Sequence[int]) -> list[Row]:
    rows = []
    for n in threads:
        seconds, run = least(lambda n=n: grow(problem.costmap, problem.goal, n), BUDGET)  # type: ignore[misc]
        reached = int(np.isfinite(run.field.values()).sum())
        who = f"ppaas dijkstra, {n} thread{'s' * (n > 1)}"
        told = {"who": who, "ours": True, "solves": "the definition", "seconds": seconds, "prepare_seconds": 0.0}
        rows.append({**told, "ns_per_cell": seconds / reached * 1e9, "off": 0.0, "other_cells": 0})
    return rows


def _field_row(peer: Peer, problem: Problem, exact: NDArray[np.float64]) -> Row:
    prepare_seconds, call = peer.call(problem)
    seconds, found = least(call, BUDGET)
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


def _our_paths(problem: Problem, cheapest: float) -> list[Row]:
    rows = []
    for name in (name for name in OURS if name in planner_names()):
        planner = create(name)
        scenario.warm(planner)
        asked = scenario.on_map(planner, problem.costmap)
        question = asked.question(*problem.start, *problem.goal)
        seconds, cells = least(lambda question=question: scenario.answer(question), BUDGET)  # type: ignore[misc]
        row = {"who": f"ppaas {name}", "ours": True, "solves": planner.purpose, "seconds": seconds,
               "prepare_seconds": asked.index_seconds}  # fmt: skip
        rows.append({**row, **_judged(problem, cells, cheapest)})
    return rows


def _path_row(peer: Peer, problem: Problem, cheapest: float) -> Row:
    prepare_seconds, call = peer.call(problem)
    seconds, found = least(call, BUDGET)
    row = {**_who(peer), "seconds": seconds, "prepare_seconds": prepare_seconds}
    return {**row, **_judged(problem, peer.told(found, problem), cheapest)}


def _judged(problem: Problem, cells: NDArray[np.integer], cheapest: float) -> Row:
    """Return how much dearer than the cheapest a path is, and whether a robot could follow it."""
    length = scenario.walked(problem.free(), cells, [*problem.start, *problem.goal])
    cost = path_cost(problem.costmap, cells.astype(np.int32)) if len(cells) else float("nan")
    return {
        "cells": len(cells),
        "off": cost / cheapest - 1.0 if cheapest else 0.0,
        "walkable": bool(np.isfinite(length)),
    }


def _who(peer: Peer) -> Row:
    return {"who": f"{peer.package} {peer.installed} {peer.name}", "ours": False, "solves": peer.solves}
