"""Bench of the growth of planning time: plans across grids of increasing size, by several planners in turn."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from rich.progress import Progress

from benchmarks.planners.grids import KINDS, SEED, check_kinds, goal_in
from benchmarks.planners.scenario import warm
from benchmarks.planners.timing import announce, cpus, in_turn, timed
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidPlanner
from ppaas.geometry import Pose2D
from ppaas.planners import create
from ppaas.planners.base import Planner, PlanRequest
from ppaas.planners.field.cost_field import CostField

FROM = 1024
"""Edge from which the growth is fitted [cells]; smaller grids fit the processor's caches."""

RUNS = 3
"""Number of plans of each planner on a grid, after the first one."""

REFERENCE = "dijkstra"
"""Planner beside which all others are measured: it prepares nothing."""


def measure(kinds: Sequence[str], sizes: Sequence[int], planners: Sequence[str], progress: Progress) -> dict[str, Any]:
    """Plan across grids of all sizes with the reference and other planners.

    Returns
    -------
    dict
        ``sizes``, ``cpus``, and by kind of grid and planner: the time of the ``first`` plan, with the preparation of
        the map, and of the ``next`` [s], both None where the planner refuses the map; ``times``, the next time divided
        by the reference's next time; the ``exponent`` with which the next time grows with the edge, None below two
        sizes; and ``wrong``, the number of plans of an optimal planner whose cost differs from the reference's.

    Raises
    ------
    NotFound
        A kind of grid or a planner is unknown.
    """
    check_kinds(kinds)
    made = {name: create(name) for name in dict.fromkeys((REFERENCE, *planners))}
    for planner in made.values():
        warm(planner)
    told = {kind: _of_kind(kind, sizes, made, progress) for kind in kinds}
    return {"sizes": list(sizes), "planners": told, "cpus": cpus()}


def _of_kind(
    kind: str, sizes: Sequence[int], planners: dict[str, Planner], progress: Progress
) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {name: {"first": [], "next": [], "times": [], "wrong": 0} for name in planners}
    for size in sizes:
        _add_size(kind, size, planners, found, progress)
    for one in found.values():
        one["exponent"] = _exponent(sizes, one["next"])
    return found


def _add_size(
    kind: str, size: int, planners: dict[str, Planner], found: dict[str, dict[str, Any]], progress: Progress
) -> None:
    announce(progress, f"scaling: {kind} {size}²")
    costmap = KINDS[kind](size, SEED).costmap
    request = across(costmap)
    firsts, costs = {}, {}
    for name, planner in planners.items():
        try:
            firsts[name], plan = timed(partial(planner.fresh().plan, costmap, request))
        except InvalidPlanner:  # such as an index that would be too large
            continue
        costs[name] = plan.cost
        planner.plan(costmap, request)
    ways = {name: partial(planners[name].plan, costmap, request) for name in firsts}
    best = in_turn(ways, progress, f"{kind} {size}²", RUNS)
    for name, one in found.items():
        one["first"].append(firsts.get(name))
        one["next"].append(best.get(name))
        one["times"].append(best[name] / best[REFERENCE] if name in best else None)
        optimal = planners[name].traits.optimal == planners[REFERENCE].traits.optimal
        one["wrong"] += int(name in costs and optimal and not np.isclose(costs[name], costs[REFERENCE]))


def across(costmap: Costmap) -> PlanRequest:
    """Return the request of a path from the first reachable cell, by row and column, to the last."""
    middle = goal_in(costmap)
    field = CostField(costmap, np.array([middle]))
    field.grow()
    rows, columns = np.nonzero(np.isfinite(field.values()))
    far = rows + columns
    start, goal = (
        Pose2D(*costmap.info.to_world((rows[at], columns[at])).tolist()) for at in (far.argmin(), far.argmax())
    )
    return PlanRequest(start, goal)


def _exponent(sizes: Sequence[int], seconds: Sequence[float | None]) -> float | None:
    """Return the exponent of the power law fitted to times over edges; None below two sizes."""
    known = [(size, second) for size, second in zip(sizes, seconds, strict=True) if size >= FROM and second is not None]
    if len(known) < 2:
        return None
    edges, times = np.log(np.array(known)).T
    return float(np.polyfit(edges, times, 1)[0])
