"""Part ``logs``: errors, false closures, speed and memory of mapping recorded and simulated logs.

Each log is mapped in its own process.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import process_usage
from benchmarks.harness.figures import Figure, PartResult
from benchmarks.harness.parallel_runs import run_all
from benchmarks.mapping.map_errors import (
    FalseClosures,
    absolute_errors,
    by_poses,
    by_relations,
    random_relations,
    surviving,
    wrong_share,
)
from benchmarks.mapping.parts.mapped import write
from benchmarks.mapping.parts.part import SlamOptions, name_of, relations_of
from benchmarks.mapping.small_worlds import ring_drive
from benchmarks.mapping.worlds import CORRIDORS, EQUAL_CORRIDORS, LABORATORY, OFFICE, drive_of, walls_of
from ppaas.errors import InvalidInput
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.pipeline.offline import LogMap, map_log
from ppaas.mapping.relations import Relations, parse_relations, score
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.scan_points import prepare
from robots.recordings.scan_logs import read_scan_log

RELATIONS_SEED = 1

SAMPLE = 300
"""Number of scans that the baseline is measured on."""


@dataclass(frozen=True, slots=True)
class SlamJob:
    """Log to map.

    Parameters
    ----------
    log : Path, optional
        Recorded log; true relations are in the file of the same name that ends with ``.relations``, if it exists.
        Without a log, a simulated world is mapped.
    world : str
        Name of the world, see `benchmarks.mapping.worlds`.
    seed : int
        Seed of the world.
    sweep : float
        Time that the simulated laser takes for a scan [s].
    """

    log: Path | None = None
    world: str = OFFICE
    seed: int = 0
    sweep: float = 0.0

    @property
    def name(self) -> str:
        """Name in the table."""
        if self.log is not None:
            return name_of(self.log)
        return f"{self.world} {self.seed}" + (f", sweep {self.sweep:g} s" if self.sweep else "")


@dataclass(frozen=True, slots=True)
class _Truth:
    """Ground truth of a log: its relations, and the true poses (n, 3) if it is simulated."""

    relations: Relations | None
    poses: NDArray[np.float64] | None


def run(job: SlamJob, folder: Path) -> dict[str, Any]:
    """Map a log after a warm-up, which compiles the kernels; return errors, times and memory.

    The memory ``own_mib`` is the part of the peak that neither the interpreter nor the kernels take, with the log;
    ``private_mib`` is the whole peak without the files of libraries.

    Parameters
    ----------
    job : SlamJob
    folder : Path
        The map is written into this folder for other parts, see `mapped`.
    """
    map_log(ring_drive().log)
    log, truth = _read(job)
    process_usage.forget_peak()
    before = process_usage.resident() - _size(log)
    begin, cpu = time.perf_counter(), time.process_time()
    made = map_log(log)
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    peak = process_usage.peak()
    duration = float(np.diff(log.stamps).clip(0.0).sum())
    write(folder, job.name, made)
    return {
        "log": job.name,
        "beams": log.geometry.beams,
        "metres": round(float(np.hypot(*np.diff(made.poses[:, :2], axis=0).T).sum()), 1),
        "minutes": round(duration / 60.0, 1),
        **made.summary(),
        "cpu_s": round(cpu, 2),
        "wall_s": round(seconds, 2),
        "times_real_time": round(duration / cpu, 1),
        "yardstick_s": round(_baseline(log), 2),
        "peak_mib": round(peak, 1),
        "private_mib": round(peak - process_usage.of_files(), 1),
        "own_mib": round(peak - before, 1),
        "stages": _errors(made, log, truth),
        "false_closures": judged._asdict() if (judged := _judged(made, log, truth)) else None,
        "wrong_cells": _wrong_cells(job, made, truth),
    }


def _size(log: ScanLog) -> float:
    """Return the memory of a log [MiB]."""
    return sum(array.nbytes for array in (log.stamps, log.odometry, log.ranges, log.first_angles)) / 2**20


def _read(job: SlamJob) -> tuple[ScanLog, _Truth]:
    if job.log is None:
        drive = drive_of(job.world, job.seed, job.sweep)
        return drive.log, _Truth(random_relations(drive.log.stamps, drive.true, RELATIONS_SEED), drive.true)
    path = relations_of(job.log)
    relations = parse_relations(path.read_text("ascii")) if path.is_file() else None
    return read_scan_log(job.log), _Truth(relations, None)


def _baseline(log: ScanLog) -> float:
    """Return the CPU time in which a k-d tree of each scan is built and each of its points looked up [s]."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - loaded before, it would count as memory of mapping

    scans, parameters = range(0, len(log), max(1, len(log) // SAMPLE)), SlamParameters()
    points = [prepare(log.ranges[scan], log.geometry_of(scan), parameters) for scan in scans]
    seen = [each.points[each.valid] for each in points]
    begin = time.process_time()
    for each in seen:
        if len(each):
            KDTree(each).query(each)
    return (time.process_time() - begin) * len(log) / len(seen)


def _judged(made: LogMap, log: ScanLog, truth: _Truth) -> FalseClosures | None:
    if truth.poses is not None:
        return by_poses(surviving(made.mapper), truth.poses)
    if truth.relations is not None:
        return by_relations(surviving(made.mapper), truth.relations, log.stamps, made.poses)
    return None


def _wrong_cells(job: SlamJob, made: LogMap, truth: _Truth) -> float | None:
    if truth.poses is None:
        return None
    return round(wrong_share(made, walls_of(job.world, job.seed), truth.poses), 6)


def _errors(made: LogMap, log: ScanLog, truth: _Truth) -> dict[str, dict[str, Any]]:
    return {name: _stage_errors(poses, log, truth) for name, poses in made.stages.items()}


def _stage_errors(poses: NDArray[np.float64], log: ScanLog, truth: _Truth) -> dict[str, Any]:
    errors: dict[str, Any] = {}
    if truth.relations is not None:
        errors |= score(truth.relations, log.stamps, poses).summary()
    if truth.poses is not None:
        absolute = absolute_errors(truth.poses, poses)
        errors |= {"absolute_m": round(float(absolute.mean()), 5), "absolute_max_m": round(float(absolute.max()), 4)}
    return errors


def row(result: dict[str, Any]) -> dict[str, str]:
    """Return the row of the table for a result."""
    last = list(result["stages"].values())[-1]
    return {
        "log": result["log"],
        "scans": str(result["scans"]),
        "m": f"{result['metres']:g}",
        "min": f"{result['minutes']:g}",
        "relations m": _with_deviation(last, "m"),
        "deg": _with_deviation(last, "deg"),
        "absolute m": f"{last['absolute_m']:.4f}" if "absolute_m" in last else "",
        "by stage m": " → ".join(f"{stage['mean_m']:.4f}" for stage in result["stages"].values() if "mean_m" in stage),
        "closures": str(result["closures"]),
        "cpu s": f"{result['cpu_s']:.1f}",
        "× real time": f"{result['times_real_time']:.0f}",
        "ms a scan": f"{1e3 * _cpu(result, 'tracking') / max(result['scans'], 1):.2f}",
        "MiB (own)": f"{result['peak_mib']:.0f} ({result['own_mib']:.0f})",
    }


def _cpu(result: dict[str, Any], part: str) -> float:
    """Return the CPU time of a part [s], which is timed by the clock."""
    seconds: float = result["seconds"][part] * result["cpu_s"] / result["wall_s"]
    return seconds


def _with_deviation(errors: dict[str, Any], unit: str) -> str:
    mean = errors.get(f"mean_{unit}", math.nan)
    if math.isnan(mean):
        return ""
    digits = 4 if unit == "m" else 3
    deviation, most = errors[f"std_{unit}"], errors[f"max_{unit}"]
    return f"{mean:.{digits}f} ± {deviation:.{digits}f} (max {most:.2f})"


SLOW_SWEEP = 0.1
"""Time of a scan of the slow laser [s]."""

FEW_BEAMS, FAST_FEW, FAST_MANY = 200, 50.0, 25.0
"""Number of beams up to which a laser has few, and the least speed with few and with many [times real time]."""

MB = 2**20 / 1e6
"""Megabytes of a MiB."""


class Bars(NamedTuple):
    """Largest errors [m], CPU time [s] and memory [MB] of a log; None without a bar."""

    mean: float | None = None
    deviation: float | None = None
    most: float | None = None
    absolute: float | None = None
    cpu: float | None = None
    memory: float | None = None
    wrong_cells: float | None = None


BARS = {
    "intel": Bars(0.0135, 0.010, 0.15, cpu=45.0, memory=150.0),
    "aces": Bars(0.036),
    "fr079": Bars(0.033),
    "killian": Bars(0.05, most=1.0, memory=250.0),
    "laboratory": Bars(0.0135, 0.010, 0.15, cpu=45.0, memory=150.0),
    "corridors": Bars(0.05, most=1.0, memory=250.0),
    "sweep": Bars(0.006, wrong_cells=1.0),
    "office": Bars(0.004, absolute=0.010, wrong_cells=1.0),
}
"""Bars of the logs whose names contain a word; the first one counts. The laboratory stands in for Intel, the corridors
for Killian."""


def measure(options: SlamOptions, done: Callable[[], None]) -> PartResult:
    """Map all logs; ``done`` is called after each.

    Raises
    ------
    InvalidInput
        There is nothing to map.
    """
    jobs = jobs_of(options)
    if not jobs:
        raise InvalidInput("nothing to map: give a LOG or --data, or leave out --no-worlds")
    results = run_all(partial(run, folder=options.folder), jobs, options.jobs, done, fresh=True)
    figures = [figure for result in results for figure in figures_of(result)]
    return PartResult(figures, [row(result) for result in results], results)


def jobs_of(options: SlamOptions) -> list[SlamJob]:
    """Return the logs to map."""
    jobs = [SlamJob(log) for log in (*options.logs, *options.recorded())]
    if options.worlds:
        for seed in range(options.offices):
            jobs += [SlamJob(seed=seed), SlamJob(seed=seed, sweep=SLOW_SWEEP)]
        jobs += [SlamJob(world=LABORATORY), SlamJob(world=CORRIDORS)]
    if options.equal_corridors:
        jobs.append(SlamJob(world=EQUAL_CORRIDORS))
    return jobs


def figures_of(result: dict[str, Any]) -> Iterator[Figure]:
    """Yield the figures of a log."""
    name = result["log"]
    bars = next((bars for word, bars in BARS.items() if word in name), Bars())
    yield from _error_figures(name, list(result["stages"].values())[-1], bars)
    if result["false_closures"] is not None:
        count = result["false_closures"]
        note = f"of {count['judged']} edges whose truth is known, {count['edges']} in all"
        yield Figure("false closures", f"{name}: over 0.5 m", count["false"], "", limit=0.0, note=note)
    if result["wrong_cells"] is not None:
        share = round(100.0 * result["wrong_cells"], 4)
        yield Figure("map", f"{name}: wrong cells", share, "%", limit=bars.wrong_cells, note="of the known ones")
    yield from _speed(name, result, bars)
    yield from _memory(name, result, bars)


def _error_figures(name: str, errors: dict[str, Any], bars: Bars) -> Iterator[Figure]:
    if "mean_m" in errors:
        note = f"± {errors['std_m']:.4f}, largest {errors['max_m']:.2f} m, of {errors['relations']}"
        yield Figure("relations", f"{name}: mean", errors["mean_m"], "m", limit=bars.mean, note=note)
    if bars.deviation is not None and "std_m" in errors:
        yield Figure("relations", f"{name}: deviation", errors["std_m"], "m", limit=bars.deviation)
    if bars.most is not None and "max_m" in errors:
        yield Figure("relations", f"{name}: largest", errors["max_m"], "m", limit=bars.most)
    if "absolute_m" in errors:
        note = f"largest {errors['absolute_max_m']:.3f} m"
        yield Figure("relations", f"{name}: absolute", errors["absolute_m"], "m", limit=bars.absolute, note=note)


def _speed(name: str, result: dict[str, Any], bars: Bars) -> Iterator[Figure]:
    floor = FAST_FEW if result["beams"] <= FEW_BEAMS else FAST_MANY
    note = f"{result['beams']} beams, {result['minutes']:g} min in {result['cpu_s']:.1f} s of CPU"
    speed = result["times_real_time"]
    yield Figure("speed", name, speed, "× real time", limit=floor, floor=True, note=note)
    baseline = round(60.0 * result["minutes"] / max(result["yardstick_s"], 1e-9), 1)
    note = "k-d tree of each scan: built, and each point looked up"
    yield Figure("speed", f"{name}: baseline", baseline, "× real time", yardstick=True, note=note)
    if bars.cpu is not None:
        yield Figure("speed", f"{name}: CPU time", result["cpu_s"], "s", limit=bars.cpu)


def _memory(name: str, result: dict[str, Any], bars: Bars) -> Iterator[Figure]:
    if bars.memory is None:
        return
    own, private, whole = (round(MB * result[key], 1) for key in ("own_mib", "private_mib", "peak_mib"))
    note = f"with the interpreter and the kernels; {own:g} MB are the log's, its map's and the mapper's"
    yield Figure("memory", name, private, "MB", limit=bars.memory, note=note)
    yield Figure("memory", f"{name}: resident", whole, "MB", note="with the files of shared libraries")
