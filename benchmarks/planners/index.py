"""Bench of the index of a map: time to build it, speed and correctness of queries, also while obstacles are seen."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from benchmarks.planners.grids import SEED, Grid
from benchmarks.planners.scenario import Asked, ScenarioScene, ask_all, walked, warm
from benchmarks.planners.timing import announce, cpus, least
from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidMap, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.formats.movingai import Scenario
from ppaas.planners import create
from ppaas.planners.base import PlanRequest
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.weights import passable

RUNS, BUDGET = 3, 12.0
"""Number of times that an index is built, and time after which it is not built again [s]."""

QUERIES = 1000
"""Number of queries."""
DRAWN = 4
"""Number of random pairs of cells for each query, since some are not connected."""

JUDGE = "jps"
"""Planner that provides the reference lengths; `scenario` checks it."""


def measure(
    grid: Grid, name: str, threads: Sequence[int], progress: Progress, queries: int = QUERIES
) -> dict[str, Any]:
    """Build an index with each number of threads, and query paths between random cells.

    Parameters
    ----------
    grid : Grid
    name : str
        Name of a planner that prepares a map.
    threads : sequence of int
    progress : Progress
        Display of the progress.
    queries : int
        Largest number of queries.

    Returns
    -------
    dict
        ``grid``, ``planner``, ``seconds`` by number of threads, ``bytes``, ``queries``, ``wrong`` ones, ``mean_us``,
        ``p50_us``, ``p99_us``, what `with_seen_obstacles` returns, ``cpus``.

    Raises
    ------
    InvalidMap
        No two connected cells were found.
    InvalidParameter
        The planner builds no index.
    InvalidPlanner
        The planner refuses to build an index of this map.
    """
    planner = create(name)
    if not isinstance(planner, PreparedPlanner):
        raise InvalidParameter(f"planner {name!r} builds no index of a map; use hub_labels or jps")
    announce(progress, f"index: {grid.name} by {name}")
    warm(planner)
    seconds, prepared = {}, None
    for n in threads:
        del prepared  # frees its memory for the next one
        making = partial(planner.prepare, grid.costmap, threads=n)
        seconds[str(n)], prepared = least(making, BUDGET, RUNS)
    assert prepared is not None
    scene = random_queries(grid, queries)
    return {
        "grid": grid.name, "planner": name, "seconds": seconds, "bytes": prepared.nbytes,
        **ask_all(Asked(lambda *ends: partial(prepared.path, *ends)), scene, progress, grid.name),
        **with_seen_obstacles(planner, scene), "cpus": cpus(),
    }  # fmt: skip


def random_queries(grid: Grid, count: int) -> ScenarioScene:
    """Return up to ``count`` queries between random connected cells."""
    free = passable(True)[grid.costmap.data]
    cells = np.argwhere(free)
    judge = create(JUDGE)
    assert isinstance(judge, PreparedPlanner)
    ways = judge.prepare(grid.costmap)
    pairs = cells[np.random.default_rng(SEED).integers(0, len(cells), (DRAWN * count if len(cells) else 0, 2))]
    found = []
    for row, column, to_row, to_column in pairs.reshape(-1, 4).tolist():
        ends = [row, column, to_row, to_column]
        length = walked(free, ways.path(row, column, to_row, to_column), ends)
        if not np.isnan(length):
            found.append((*ends, length))
        if len(found) == count:
            break
    if not found:
        raise InvalidMap("no two connected free cells were found on the map")
    starts, goals, lengths = np.split(np.array(found), (2, 4), axis=1)
    return ScenarioScene(grid.name, Scenario(starts.astype(int), goals.astype(int), lengths.ravel()), grid.costmap)


# -- bench of an indexed planner while a robot sees obstacles ----------------------------------------------------------

PLANS = 20
"""Number of plans."""

WINDOW = 120
"""Width of the local costmap of a robot [cells]."""

MARKED, BESIDE = 200, 3
"""Number of cells that a robot has marked, and their least distance from the path [cells]: the plan stays the same."""


def with_seen_obstacles(planner: PreparedPlanner, scene: ScenarioScene) -> dict[str, Any]:
    """Plan on a map, and on copies of it with obstacles that a robot sees beside its path.

    Returns
    -------
    dict
        ``plans``; the median time of a plan on the map alone, ``map_us``, and with the obstacles, ``seen_us``; and how
        many of these were ``seen_wrong``: of another cost.
    """
    static, rng = scene.costmap.read_only(), np.random.default_rng(SEED)
    alone, seen, wrong = [], [], 0
    for request in _requests(scene):
        seconds, plan = least(partial(planner.plan, static, request))
        alone.append(seconds)
        current = _with_obstacles(static, plan.cells, rng)
        seconds, now = least(partial(planner.plan, current, request))
        seen.append(seconds)
        wrong += not np.isclose(now.cost, plan.cost)
    return {
        "plans": len(alone),
        "map_us": 1e6 * float(np.median(alone)),
        "seen_us": 1e6 * float(np.median(seen)),
        "seen_wrong": wrong,
    }


def _requests(scene: ScenarioScene) -> Iterator[PlanRequest]:
    for start, goal in zip(scene.queries.starts[:PLANS], scene.queries.goals[:PLANS], strict=True):
        begin, end = (Pose2D(*scene.costmap.info.to_world(cell).tolist()) for cell in (start, goal))
        yield PlanRequest(begin, end)


def _with_obstacles(static: Costmap, path: NDArray[np.int32], rng: np.random.Generator) -> Costmap:
    """Return a copy of the map with obstacles in a window about a cell of the path, but not on the path."""
    corner = np.maximum(path[rng.integers(len(path))] - WINDOW // 2, 0)
    window = slice(int(corner[0]), int(corner[0]) + WINDOW), slice(int(corner[1]), int(corner[1]) + WINDOW)
    current = static.copied(window)
    drawn = corner + rng.integers(0, np.array(static.data[window].shape), (MARKED, 2))
    for cell in drawn:
        if np.abs(path - cell).max(axis=1).min() >= BESIDE:
            current.data[tuple(cell)] = LETHAL_OBSTACLE
    return current
