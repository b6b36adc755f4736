"""Bench of map preparation and planning without a cloud.

Times are the minimum of several runs on one thread, after a warm-up. A path runs from corner to corner, so that its
field covers nearly the whole grid.

On one core of the reference machine, costmap_2d took 590 ms and OpenCV 359 ms for the same inflation, and ROS's
depthimage_to_laserscan took 136 µs a scan.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeVar

import numba
import numpy as np
from rich.progress import Progress

from benchmarks.harness.figures import Figure
from ppaas.clock import monotonic
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.inflation_layer import inflate
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.perception.depth_scan import DepthScanner, DepthScanParameters, PinholeCamera
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.grid.dijkstra import Dijkstra

T = TypeVar("T")

PART = "planning"
RUNS = 5
SIZES, QUICK = (1024, 4096), (256,)
RESOLUTION = 0.05
MARGIN = 10
"""Distance of start and goal from the edges [cells]."""


def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Prepare maps, and plan a path across each."""
    figures = []
    for name, map_ in progress.track(list(grids(QUICK if quick else SIZES)), description="planning"):
        layers, _ = best(lambda map_=map_: build_layers(map_))  # type: ignore[misc]
        seconds, plan = plan_across(map_)
        note = f"{seconds / plan.expanded * 1e9:.1f} ns a cell, {plan.expanded:,} settled; path {plan.length:.0f} m"
        figures.append(Figure(PART, f"{name}, layers", round(layers * 1e3, 1), "ms"))
        figures.append(Figure(PART, f"{name}, dijkstra", round(seconds * 1e3, 1), "ms", note=note))
    return figures


def grids(sizes: tuple[int, ...]) -> Iterator[tuple[str, GridMap]]:
    """Yield empty grids and grids with pillars, by name."""
    for size in sizes:
        yield f"empty {size}²", grid(np.full((size, size), FREE, np.int8))
        random = np.random.default_rng(size).random((size, size)) < 0.0005
        for row, column in ((0, 0), (size - 2 * MARGIN, size - 2 * MARGIN)):
            random[row : row + 2 * MARGIN, column : column + 2 * MARGIN] = False
        yield f"pillars {size}²", grid(np.where(random, OCCUPIED, FREE).astype(np.int8))


def grid(data: np.ndarray) -> GridMap:
    """Return the map of some cells."""
    height, width = data.shape
    return GridMap(data, GridInfo(RESOLUTION, width, height))


def best(work: Callable[[], T]) -> tuple[float, T]:
    """Return the time of the fastest run [s] and its result, after a warm-up."""
    result = work()
    seconds = float("inf")
    for _ in range(RUNS):
        began = monotonic()
        result = work()
        seconds = min(seconds, monotonic() - began)
    return seconds, result


def plan_across(map_: GridMap) -> tuple[float, PlanResult]:
    """Plan on the inflated costmap from the lower left corner to the upper right one."""
    costmap = build_layers(map_).costmap
    (x0, y0), (x1, y1) = (costmap.info.to_world(cell).tolist() for cell in corners(map_.info))
    request = PlanRequest(Pose2D(x0, y0, 0.0), Pose2D(x1, y1, 0.0), tolerance=1.0)
    return best(lambda: Dijkstra().plan(costmap, request))


def corners(info: GridInfo) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return cells near the first and the last cell of the grid."""
    return (MARGIN, MARGIN), (info.height - 1 - MARGIN, info.width - 1 - MARGIN)


# -- bench of costmap preparation --------------------------------------------------------------------------------------

PREPARING = "preparing"
SIZE = 4096
RADIUS = 0.55
"""Inflation radius [m]."""
MOST_INFLATION, MOST_DEPTH = 150.0, 0.03
"""Largest acceptable times of an inflation on two threads, and of a scan on one [ms]."""
ROWS, SCANS = 10, 200
"""Rows of a depth image that a scan uses, and number of scans in a run: one alone is too short to be timed."""


def measure_preparation(progress: Progress, quick: bool) -> list[Figure]:
    """Inflate maps on one thread and on two, and convert depth images to scans."""
    sizes = QUICK if quick else (SIZE,)
    inflated = [
        _inflation(name, map_, threads)
        for name, map_ in progress.track(list(grids(sizes)), description="inflation")
        for threads in range(1, min(2, numba.get_num_threads()) + 1)
    ]
    return inflated + [_depth_scan(kind) for kind in (np.uint16, np.float32)]


def _inflation(name: str, map_: GridMap, threads: int) -> Figure:
    before = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        seconds, _ = best(partial(_inflated, map_))
    finally:
        numba.set_num_threads(before)
    told = f"{name}, exact inflation {RADIUS:g} m, threads {threads}"
    return Figure(PREPARING, told, round(1e3 * seconds, 1), "ms", limit=MOST_INFLATION if threads == 2 else None)


def _inflated(map_: GridMap) -> object:
    return inflate(distance_to_occupied(map_), inscribed_radius=0.18, inflation_radius=RADIUS)


def _depth_scan(kind: type[np.uint16] | type[np.float32]) -> Figure:
    camera = PinholeCamera(640, 480, 554.3, 319.5, 239.5)
    scanner = DepthScanner(camera, DepthScanParameters(scan_height=ROWS))
    depths = np.random.default_rng(1).uniform(0.3, 11.0, (camera.height, camera.width))
    image = (1e3 * depths if kind is np.uint16 else depths).astype(kind)
    seconds, _ = best(partial(_scans, scanner, image))
    told = f"depth image 640×480 {image.dtype} → scan, {ROWS} rows"
    return Figure(PREPARING, told, round(1e3 * seconds / SCANS, 4), "ms", limit=MOST_DEPTH)


def _scans(scanner: DepthScanner, image: np.ndarray) -> None:
    for _ in range(SCANS):
        scanner.scan(image)
