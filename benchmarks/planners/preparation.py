"""Bench of costmap preparation: inflation of whole maps, and scans from depth images.

On one core of the reference machine, costmap_2d took 590 ms and OpenCV 359 ms for the same inflation, and ROS's
depthimage_to_laserscan took 136 µs a scan.
"""

from functools import partial

import numba
import numpy as np
from rich.progress import Progress

from benchmarks.harness.figures import Figure
from benchmarks.planners.planning import QUICK, best, grids
from ppaas.costmap.inflation_layer import inflate
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import GridMap
from ppaas.perception.depth_scan import DepthScanner, DepthScanParameters, PinholeCamera

PART = "preparing"
SIZE = 4096
RADIUS = 0.55
"""Inflation radius [m]."""
MOST_INFLATION, MOST_DEPTH = 150.0, 0.03
"""Largest acceptable times of an inflation on two threads, and of a scan on one [ms]."""
ROWS, SCANS = 10, 200
"""Rows of a depth image that a scan uses, and number of scans in a run: one alone is too short to be timed."""


def measure(progress: Progress, quick: bool) -> list[Figure]:
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
    return Figure(PART, told, round(1e3 * seconds, 1), "ms", limit=MOST_INFLATION if threads == 2 else None)


def _inflated(map_: GridMap) -> object:
    return inflate(distance_to_occupied(map_), inscribed_radius=0.18, inflation_radius=RADIUS)


def _depth_scan(kind: type[np.uint16] | type[np.float32]) -> Figure:
    camera = PinholeCamera(640, 480, 554.3, 319.5, 239.5)
    scanner = DepthScanner(camera, DepthScanParameters(scan_height=ROWS))
    depths = np.random.default_rng(1).uniform(0.3, 11.0, (camera.height, camera.width))
    image = (1e3 * depths if kind is np.uint16 else depths).astype(kind)
    seconds, _ = best(partial(_scans, scanner, image))
    told = f"depth image 640×480 {image.dtype} → scan, {ROWS} rows"
    return Figure(PART, told, round(1e3 * seconds / SCANS, 4), "ms", limit=MOST_DEPTH)


def _scans(scanner: DepthScanner, image: np.ndarray) -> None:
    for _ in range(SCANS):
        scanner.scan(image)
