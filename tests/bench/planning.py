"""How fast maps are prepared and paths are planned: ``make bench``.

The least of several runs on one thread, compiled before the first. A plan goes from corner to corner, so that its
field covers nearly the whole grid.
"""

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np
from rich.console import Console
from rich.table import Table

from ppaas.clock import monotonic
from ppaas.costmap.build import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.dijkstra import Dijkstra

T = TypeVar("T")

RUNS = 5
RESOLUTION = 0.05
MARGIN = 10
"""Cells from the edge to start and goal."""


def grids() -> Iterator[tuple[str, GridMap]]:
    """Yield empty and cluttered grids by name."""
    for size in (1024, 4096):
        yield f"empty {size}²", grid(np.full((size, size), FREE, np.int8))
        random = np.random.default_rng(size).random((size, size)) < 0.0005
        for row, column in ((0, 0), (size - 2 * MARGIN, size - 2 * MARGIN)):
            random[row : row + 2 * MARGIN, column : column + 2 * MARGIN] = False
        yield f"pillars {size}²", grid(np.where(random, OCCUPIED, FREE).astype(np.int8))


def grid(data: np.ndarray) -> GridMap:
    """Make a map of its cells."""
    height, width = data.shape
    return GridMap(data, GridInfo(RESOLUTION, width, height))


def best(work: Callable[[], T]) -> tuple[float, T]:
    """Return the seconds of the fastest run, and its result; the first, which may compile, does not count."""
    result = work()
    seconds = float("inf")
    for _ in range(RUNS):
        began = monotonic()
        result = work()
        seconds = min(seconds, monotonic() - began)
    return seconds, result


def plan_across(map_: GridMap) -> tuple[float, PlanResult]:
    """Plan over the inflated costmap from the lower-left corner to the upper-right."""
    costmap = build_layers(map_).costmap
    start, goal = (Pose2D(*costmap.info.to_world(cell).tolist(), 0.0) for cell in corners(map_.info))
    return best(lambda: Dijkstra().plan(costmap, PlanRequest(start, goal, tolerance=1.0)))


def corners(info: GridInfo) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return a cell near the first and a cell near the last."""
    return (MARGIN, MARGIN), (info.height - 1 - MARGIN, info.width - 1 - MARGIN)


def main() -> None:
    """Print one line a grid."""
    table = Table("grid", "layers, ms", "plan, ms", "settled cells", "plan, ns a cell", "path, m")
    for name, map_ in grids():
        layers, _ = best(lambda map_=map_: build_layers(map_))
        seconds, plan = plan_across(map_)
        figures = (layers * 1e3, seconds * 1e3, seconds / plan.expanded * 1e9, plan.length)
        layers_ms, plan_ms, cell_ns, length = (f"{figure:,.1f}" for figure in figures)
        table.add_row(name, layers_ms, plan_ms, f"{plan.expanded:,}", cell_ns, length)
    Console().print(table)


if __name__ == "__main__":
    main()
