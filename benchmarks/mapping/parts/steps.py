"""Part ``steps``: from a scan to its pose, a search for a loop, and the layers of a map, beside baselines."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.office import office, route
from benchmarks.mapping.parts.part import SlamOptions
from benchmarks.mapping.simulated_drive import simulate
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import Blur, MotionWindow, build_pyramid, search
from ppaas.mapping.closures.kernels.points import gather
from ppaas.mapping.kernels.correlation import search as exhaustive_search
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.scan_points import prepare
from ppaas.maps.generate import office as office_map
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap

SCANS = 1500
"""Number of scans that are mapped."""

SEARCHED, TURN, RESOLUTION, TURN_STEP = 4.0, 90.0, 0.05, 0.015
"""Window that is searched: edge [m], rotation [degrees], steps [m, rad]."""

SEARCHES, TARGET = 20, 30
"""Number of searches, and number of key frames that a scan is searched in."""

MAP_SIDE, BUILDS = 100.0, 10
"""Edge of the map whose layers are built [m], of cells of 0.05 m, and number of times."""

SCAN, SEARCH = "scan to pose", f"search of {SEARCHED:g} m × {TURN:g}°"


LIMITS_MS = {SCAN: 20.0, SEARCH: 10.0}
"""Largest times: of 99 % of the scans, and of a search on average [ms]."""


def measure(_options: SlamOptions) -> PartResult:
    """Measure all steps."""
    log = simulate(office(0), route(), 0).log.first(SCANS)
    drive(log)  # compiles or loads the kernels
    frames, latencies = drive(log)
    results = [latencies.result(), searches(frames), layers(office_map(0, MAP_SIDE, MAP_SIDE))]
    return PartResult([figure for result in results for figure in figures_of(result)], list(map(row, results)), results)


def figures_of(result: dict[str, Any]) -> list[Figure]:
    """Return the time of a step, and that of its baseline."""
    step = result["step"]
    name, value = (f"{step}: 99 % within", "p99_ms") if step == SCAN else (f"{step}: mean", "mean_ms")
    note = f"mean {result['mean_ms']:.2f}, largest {result['max_ms']:.1f} ms, of {result['count']}"
    return [
        Figure("steps", name, result[value], "ms", limit=LIMITS_MS.get(step), note=note),
        Figure(
            "steps", f"{step}: baseline", result["yardstick_mean_ms"], "ms", yardstick=True, note=result["yardstick"]
        ),
    ]


class Latencies:
    """CPU times of each scan [s]: of mapping, and of a k-d tree of its points."""

    def __init__(self) -> None:
        self.mapping: list[float] = []
        self.baseline: list[float] = []

    def result(self) -> dict[str, Any]:
        """Return the percentiles [ms]."""
        return _result(SCAN, self.mapping, "k-d tree of a scan: built, and each point looked up", self.baseline)


def drive(log: ScanLog) -> tuple[KeyFrames, Latencies]:
    """Map a drive scan by scan; the searches for closures, which run in another thread, are not counted."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - of the extra bench

    mapper, parameters, latencies = LiveMapper(log.geometry), SlamParameters(), Latencies()
    for scan, odometry in enumerate(log.odometry.tolist()):
        begin = time.thread_time()
        points = prepare(log.ranges[scan], log.geometry_of(scan), parameters)
        mapper.add(points, Pose2D(*odometry))
        latencies.mapping.append(time.thread_time() - begin)
        seen = points.points[points.valid]
        begin = time.thread_time()
        KDTree(seen).query(seen)
        latencies.baseline.append(time.thread_time() - begin)
        work = mapper.next_work()
        if work is not None:
            closed = work(lambda: False)
            begin = time.thread_time()
            mapper.apply(closed)
            latencies.mapping[-1] += time.thread_time() - begin
    return mapper.key_frames, latencies


def searches(frames: KeyFrames) -> dict[str, Any]:
    """Search scans in the key frames around them, from a wrong pose, by branch and bound and exhaustively."""
    random, times, exhaustive, found = np.random.default_rng(0), [], [], []
    window = MotionWindow(SEARCHED / 2.0, SEARCHED / 2.0, np.radians(TURN) / 2.0, TURN_STEP)
    for source in random.integers(TARGET, len(frames) - TARGET, SEARCHES + 1).tolist():
        target = slice(source - TARGET, source)
        wrong = random.uniform(-0.9, 0.9, 3) * (window.x, window.y, window.turn)
        origin = frames.poses[source]
        old = _gathered(frames, target, origin)
        new = _gathered(frames, slice(source, source + 1), origin + wrong)
        begin = time.thread_time()
        pyramid = build_pyramid(old, (40.0, 40.0), Blur(RESOLUTION, 0.1), window.levels(RESOLUTION))
        match = search(pyramid, new, window)
        times.append(time.thread_time() - begin)
        assert match is not None
        found.append(match.score)
        height, width = pyramid.sizes[0, 1:]
        grid = pyramid.values[: height * width].reshape(height, width)
        begin = time.thread_time()
        x0, y0 = pyramid.corner.tolist()
        exhaustive_search(
            grid, x0, y0, RESOLUTION, new.astype(np.float32), np.ones(len(new), np.bool_), 1, np.zeros(3),
            round(window.x / RESOLUTION), round(window.turn / TURN_STEP), TURN_STEP,
        )  # fmt: skip
        exhaustive.append(time.thread_time() - begin)
    result = _result(SEARCH, times[1:], "all motions of the window", exhaustive[1:])
    return {**result, "least_score": round(min(found[1:]), 3)}


def layers(grid: GridMap) -> dict[str, Any]:
    """Build the layers of a map, as Move Base does each second while the map grows."""
    from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - of the extra bench

    free, times, baseline = grid.data < OCCUPIED_THRESHOLD, [], []
    for _ in range(BUILDS + 1):
        begin = time.process_time()
        build_layers(grid, threads=1)
        times.append(time.process_time() - begin)
        begin = time.process_time()
        distance_transform_edt(free)
        baseline.append(time.process_time() - begin)
    height, width = grid.data.shape
    return _result(f"layers of {width} × {height} cells", times[1:], "distance transform of scipy", baseline[1:])


def _gathered(frames: KeyFrames, chosen: slice, origin: NDArray[np.float64]) -> NDArray[np.float64]:
    poses = frames.poses[chosen]
    poses.flags.writeable = False  # as those of a pose graph
    points: NDArray[np.float64] = gather(frames.points[chosen], frames.valid[chosen], poses, origin)
    return points


def _result(step: str, times: list[float], baseline: str, baseline_times: list[float]) -> dict[str, Any]:
    return {
        "step": step,
        "count": len(times),
        "mean_ms": round(1e3 * float(np.mean(times)), 3),
        "p99_ms": round(1e3 * float(np.percentile(times, 99.0)), 3),
        "max_ms": round(1e3 * max(times), 3),
        "yardstick": baseline,
        "yardstick_mean_ms": round(1e3 * float(np.mean(baseline_times)), 3),
    }


def row(result: dict[str, Any]) -> dict[str, str]:
    """Return the row of the table for a result."""
    return {
        "step": result["step"],
        "count": str(result["count"]),
        "mean ms": f"{result['mean_ms']:.2f}",
        "p99 ms": f"{result['p99_ms']:.2f}",
        "max ms": f"{result['max_ms']:.1f}",
        "baseline": result["yardstick"],
        "baseline mean ms": f"{result['yardstick_mean_ms']:.2f}",
    }
