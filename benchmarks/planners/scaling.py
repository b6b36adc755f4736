"""Bench of scaling: time per cell of the full cost field, and of plans by several planners, by size of the grid."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from rich.progress import Progress

from benchmarks.planners.field import grow_uncached, warm_up
from benchmarks.planners.grids import KINDS, SEED, Grid, check_kinds, goal_in
from benchmarks.planners.scenario import warm
from benchmarks.planners.timing import announce, cpus, in_turn, on_threads, timed
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidParameter, InvalidPlanner
from ppaas.geometry import Pose2D
from ppaas.planners import create
from ppaas.planners.base import Planner, PlanRequest
from ppaas.planners.ends import Cell
from ppaas.planners.field.cost_field import CostField
from robots.pictures.line_chart import Axis, Line

SMALLEST, LARGEST = 256, 8192
"""Smallest and largest edge [cells]."""
FROM = 512
"""Edge from which the time per cell should stay constant [cells]; smaller grids fit the processor's caches."""
RUNS, PASSES = 3, 2
"""Number of consecutive runs of a size, and of passes over all sizes: a temporary disturbance then affects no size in
all of its runs."""
SAME_SIZE_EDGE, MOST_OF_A_SIZE = 2048, 16
"""Small grids take turns with others of their size, as many as fit a grid of this edge [cells], and at most this many:
the branch predictor and the caches would adapt to a single small grid, but not to a large one."""

Told = dict[str, dict[str, float]]
"""``seconds`` and ``ns_per_cell``, by number of threads."""

KINDS_SHOWN = ("empty", "random 20 %", "maze")
"""Kinds of grids that are measured by default."""


class _SameSize(NamedTuple):
    """Grids of one kind and size, a goal in each, and the total number of reached cells."""

    grids: list[Grid]
    goals: list[Cell]
    reached: int


def sizes_up_to(largest: int) -> list[int]:
    """Return the edges 256, 512 … up to ``largest`` [cells].

    Raises
    ------
    InvalidParameter
        ``largest`` is below the smallest edge.
    """
    if largest < SMALLEST:
        raise InvalidParameter(f"the largest edge must be {SMALLEST} cells or more, not {largest}")
    return [SMALLEST << power for power in range((largest // SMALLEST).bit_length())]


def measure(kinds: Sequence[str], sizes: Sequence[int], threads: Sequence[int], progress: Progress) -> dict[str, Any]:
    """Compute the full field of grids of all sizes.

    Returns
    -------
    dict
        ``sizes`` and, by kind of grid and number of threads, ``seconds`` and ``ns_per_cell``, one number for each size,
        and the ``spread``: the ratio of the largest to the smallest time per cell, of grids from 512² on if there are
        any.

    Raises
    ------
    NotFound
        A kind of grid is unknown.
    """
    check_kinds(kinds)
    told = {
        kind: _of_kind([_same_size(kind, size, threads, progress) for size in sizes], threads, progress)
        for kind in kinds
    }
    by = {
        key: {kind: {str(n): [one[key][str(n)] for one in fields] for n in threads} for kind, fields in told.items()}
        for key in ("seconds", "ns_per_cell")
    }
    spread = {
        kind: {n: _spread(sizes, values) for n, values in by_threads.items()}
        for kind, by_threads in by["ns_per_cell"].items()
    }
    return {"sizes": list(sizes), **by, "spread": spread, "cpus": cpus()}


def _same_size(kind: str, size: int, threads: Sequence[int], progress: Progress) -> _SameSize:
    announce(progress, f"scaling: making {kind} {size}²")
    grids = [
        KINDS[kind](size, SEED + number) for number in range(min(MOST_OF_A_SIZE, max(1, SAME_SIZE_EDGE // size) ** 2))
    ]
    goals = [goal_in(grid.costmap) for grid in grids]
    reached = sum(warm_up(grid.costmap, goal, threads) for grid, goal in zip(grids, goals, strict=True))
    return _SameSize(grids, goals, reached)


def _of_kind(sizes: Sequence[_SameSize], threads: Sequence[int], progress: Progress) -> list[Told]:
    """Return the mean time of a field of each size [s], and the time per reached cell [ns]."""
    passes = [[_of_size(same_size, threads, progress) for same_size in sizes] for _ in range(PASSES)]
    least = [{n: min(one[n] for one in measured) for n in measured[0]} for measured in zip(*passes, strict=True)]
    return [
        {
            "seconds": {n: seconds / len(same_size.grids) for n, seconds in total.items()},
            "ns_per_cell": {n: seconds / same_size.reached * 1e9 for n, seconds in total.items()},
        }
        for same_size, total in zip(sizes, least, strict=True)
    ]


def _of_size(same_size: _SameSize, threads: Sequence[int], progress: Progress) -> dict[str, float]:
    """Return the total time of the fields of all grids [s], by number of threads."""
    name = same_size.grids[0].name
    announce(progress, f"scaling: {name}")
    works = {
        f"{n} {number}": partial(grow_uncached, grid.costmap, goal, n)
        for n in threads  # not in turn: a container always has the same number, so each thread finds its part cached
        for number, (grid, goal) in enumerate(zip(same_size.grids, same_size.goals, strict=True))
    }
    best = in_turn(works, progress, name, RUNS)
    return {str(n): sum(best[f"{n} {number}"] for number in range(len(same_size.grids))) for n in threads}


def _spread(sizes: Sequence[int], values: Sequence[float]) -> float:
    counted = [value for size, value in zip(sizes, values, strict=True) if size >= FROM] or values
    return max(counted) / min(counted)


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return title, lines and axes of the chart: a colour for each kind of grid, dashed lines for one thread."""
    lines = [
        Line(
            f"{kind}, {on_threads(n)}",
            list(zip(told["sizes"], values, strict=True)),
            colour=number,
            dashed=n == "1",
        )
        for number, (kind, by_threads) in enumerate(told["ns_per_cell"].items())
        for n, values in by_threads.items()
    ]
    return (
        "Time of the full cost field per reached cell",
        lines,
        Axis("edge length of the square grid [cells], logarithmic", True, told["sizes"]),
        Axis("time per reached cell [ns], logarithmic", True),
    )


# -- bench of the growth of planning time ------------------------------------------------------------------------------

GROWTH_FROM = 1024
"""Edge from which the growth is fitted [cells]; smaller grids fit the processor's caches."""

GROWTH_RUNS = 3
"""Number of plans of each planner on a grid, after the first one."""

REFERENCE = "dijkstra"
"""Planner beside which all others are measured: it prepares nothing."""


def measure_growth(
    kinds: Sequence[str], sizes: Sequence[int], planners: Sequence[str], progress: Progress
) -> dict[str, Any]:
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
    told = {kind: _growth_of_kind(kind, sizes, made, progress) for kind in kinds}
    return {"sizes": list(sizes), "planners": told, "cpus": cpus()}


def _growth_of_kind(
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
    best = in_turn(ways, progress, f"{kind} {size}²", GROWTH_RUNS)
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
    known = [
        (size, second)
        for size, second in zip(sizes, seconds, strict=True)
        if size >= GROWTH_FROM and second is not None
    ]
    if len(known) < 2:
        return None
    edges, times = np.log(np.array(known)).T
    return float(np.polyfit(edges, times, 1)[0])
