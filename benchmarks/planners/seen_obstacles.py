"""Bench of an indexed planner while a robot sees obstacles: the same plans on the map alone, and with them."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.planners.grids import SEED
from benchmarks.planners.scenario import ScenarioScene
from benchmarks.planners.timing import least
from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.prepared import PreparedPlanner

PLANS = 20
"""Number of plans."""

WINDOW = 120
"""Width of the local costmap of a robot [cells]."""

MARKED, BESIDE = 200, 3
"""Number of cells that a robot has marked, and their least distance from the path [cells]: the plan stays the same."""


def measure(planner: PreparedPlanner, scene: ScenarioScene) -> dict[str, Any]:
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
