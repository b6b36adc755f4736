"""Part ``lifelong``: memory of a robot that maps the same place for an hour, and then for another one."""

import ctypes
import gc
import time
from typing import Any

import numpy as np
import psutil

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.office import office, route
from benchmarks.mapping.parts.part import SlamOptions
from benchmarks.mapping.simulated_drive import STEP, SimulatedDrive, drive, simulate
from ppaas.geometry import Pose2D
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import prepare
from ppaas.mapping.serialization.mapping_log import LogWriter
from ppaas.planar_poses import relative

HOUR = 3600.0
"""Time between two measurements [s]."""

HOURS = 2
"""Number of hours driven."""


class Log:
    """Log of the map as a cloud stores it, of which only the size is kept."""

    def __init__(self) -> None:
        self._writer, self._sizes = LogWriter("laser"), dict[int, int]()

    def write(self, mapper: LiveMapper) -> None:
        """Append what is new."""
        if mapper.is_rewritten:
            self._writer = self._writer.restarted(list(self._sizes))
        change = self._writer.write(mapper.growing())
        if change is not None:
            self._sizes |= {entry.number: len(entry.data) for entry in change.entries}
            for number in change.obsolete:
                del self._sizes[number]

    @property
    def size(self) -> int:
        """Size of all entries [bytes]."""
        return sum(self._sizes.values())


def run() -> list[dict[str, Any]]:
    """Drive the same way for some hours, and map; see `mapped`."""
    return mapped(_drive(HOURS * HOUR), HOUR)


def mapped(way: SimulatedDrive, hour: float) -> list[dict[str, Any]]:
    """Map a way; return the memory, the size of the map and the error of the pose after each ``hour`` [s]."""
    mapper = LiveMapper(way.log.geometry, lifelong=LifelongParameters())
    results: list[dict[str, Any]] = []
    parameters, log, cpu = SlamParameters(), Log(), time.process_time()
    for scan, odometry in enumerate(way.log.odometry.tolist()):
        tracked = mapper.add(prepare(way.log.ranges[scan], way.log.geometry, parameters), Pose2D(*odometry))
        while tracked.is_key and (work := mapper.next_work()) is not None:
            mapper.apply(work(lambda: False))
        if tracked.is_key:
            log.write(mapper)
        if way.log.stamps[scan] >= (len(results) + 1) * hour:
            mapper.draw()
            error, seconds = _error(mapper, way, scan), time.process_time() - cpu
            results.append({"hour": len(results) + 1, **_state(mapper, log), "error_m": error, "cpu_s": seconds})
    return results


def _drive(seconds: float) -> SimulatedDrive:
    """Return a drive along the same way, again and again, for some time."""
    once = STEP * len(drive(route()))
    times = int(seconds / once) + 2
    way = np.concatenate([route(), *[route()[1:]] * (times - 1)])
    whole = simulate(office(0), way, 0)
    return whole.first(int(np.searchsorted(whole.log.stamps, seconds, side="right")) + 1)


def _state(mapper: LiveMapper, log: Log) -> dict[str, Any]:
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)  # else what was freed counts
    return {
        "memory_mb": round(psutil.Process().memory_info().rss / 1e6, 2),
        "key_frames": len(mapper.key_frames),
        "edges": mapper.graph.edge_count,
        "log_mb": round(log.size / 1e6, 3),
    }


def _error(mapper: LiveMapper, drive: SimulatedDrive, scan: int) -> float:
    """Return the distance of the robot's pose from the true one [m]; the map frame is that of the first pose."""
    true = relative(drive.true[0], drive.true[scan])
    pose = mapper.pose @ drive.log.geometry.mount.inverse()
    return float(np.hypot(pose.x - true[0], pose.y - true[1]))


def rows(results: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the rows of the table."""
    before = [results[0], *results]
    return [_row(result, earlier) for result, earlier in zip(results, before, strict=False)]


def _row(result: dict[str, Any], earlier: dict[str, Any]) -> dict[str, str]:
    return {
        "hour": str(result["hour"]),
        "key frames": str(result["key_frames"]),
        "edges": str(result["edges"]),
        "memory MB": f"{result['memory_mb']:.1f}",
        "growth MB": f"{result['memory_mb'] - earlier['memory_mb']:+.1f}",
        "log MB": f"{result['log_mb']:.2f}",
        "error m": f"{result['error_m']:.3f}",
        "cpu s": f"{result['cpu_s']:.0f}",
    }


GROWTH_LIMIT = 2.0
"""Largest growth in the second hour [MB]."""


def measure(_options: SlamOptions) -> PartResult:
    """Map the office for two hours with mode lifelong."""
    results = run()
    return PartResult([figure_of(results)], rows(results), results)


def figure_of(results: list[dict[str, Any]]) -> Figure:
    """Return the growth of the memory in the last hour."""
    before, after = results[-2:]
    growth = round(after["memory_mb"] - before["memory_mb"], 2)
    note = f"{after['memory_mb']:.0f} MB; from {before['key_frames']} to {after['key_frames']} key frames"
    return Figure("lifelong", "the next hour in the same place", growth, "MB", limit=GROWTH_LIMIT, note=note)
