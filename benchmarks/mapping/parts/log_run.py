"""One run of the mapping bench: maps a log in a process of its own, and compares it with the truth."""

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping import process_memory
from benchmarks.mapping.false_closures import FalseClosures, by_poses, by_relations, surviving
from benchmarks.mapping.map_cells import wrong_share
from benchmarks.mapping.parts.mapped import write
from benchmarks.mapping.parts.part import name_of, relations_of
from benchmarks.mapping.ring import ring_drive
from benchmarks.mapping.true_error import absolute_errors, random_relations
from benchmarks.mapping.worlds import OFFICE, drive_of, walls_of
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
    process_memory.forget_peak()
    before = process_memory.resident() - _size(log)
    begin, cpu = time.perf_counter(), time.process_time()
    made = map_log(log)
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    peak = process_memory.peak()
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
        "private_mib": round(peak - process_memory.of_files(), 1),
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
    from scipy.spatial import KDTree  # noqa: PLC0415 - its memory is not that of mapping

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
    """Return the errors after each stage of the pipeline."""
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
