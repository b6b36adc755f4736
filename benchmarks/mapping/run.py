"""One run of the mapping bench: maps a log in a process of its own, and compares it with the truth."""

import math
import resource
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from numpy.typing import NDArray

from benchmarks.mapping.corridors import corridor_route, corridors
from benchmarks.mapping.office import office, route
from benchmarks.mapping.ring import ring_drive
from benchmarks.mapping.simulated_drive import SimulatedDrive, simulate
from benchmarks.mapping.true_error import absolute_errors, random_relations
from ppaas.mapping.pipeline.offline import LogMap, map_log
from ppaas.mapping.relations import Relations, parse_relations, score
from ppaas.mapping.scan_log import ScanLog
from robots.recordings.scan_logs import read_scan_log

RELATIONS_SEED = 1


@dataclass(frozen=True, slots=True)
class SlamJob:
    """Log to map.

    Parameters
    ----------
    log : Path, optional
        Recorded log; true relations are in the file of the same name that ends with ``.relations``, if it exists.
        Without a log, the simulated office is mapped.
    seed : int
        Seed of the office.
    sweep : float
        Time that the simulated laser takes for a scan [s].
    corridors : bool
        Whether the simulated corridors are mapped instead of the office.
    """

    log: Path | None = None
    seed: int = 0
    sweep: float = 0.0
    corridors: bool = False

    @property
    def name(self) -> str:
        """Name in the table."""
        if self.log is not None:
            return self.log.name.partition(".")[0]
        if self.corridors:
            return f"corridors {self.seed}"
        return f"office {self.seed}" + (f", sweep {self.sweep:g} s" if self.sweep else "")


@dataclass(frozen=True, slots=True)
class _Truth:
    """Ground truth of a log: its relations, and the true poses (n, 3) if it is simulated."""

    relations: Relations | None
    poses: NDArray[np.float64] | None


def run(job: SlamJob) -> dict[str, Any]:
    """Map a log after a warm-up, which compiles the kernels; return errors, times and memory.

    The memory ``own_mib`` is the part of the peak that neither the interpreter nor the kernels take.
    """
    map_log(ring_drive().log)
    memory = _resident()
    log, truth = _read(job)
    begin, cpu = time.perf_counter(), time.process_time()
    made = map_log(log)
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    driven = float(np.hypot(*np.diff(made.poses[:, :2], axis=0).T).sum())
    duration = float(np.diff(log.stamps).clip(0.0).sum())
    return {
        "log": job.name,
        "metres": round(driven, 1),
        "minutes": round(duration / 60.0, 1),
        **made.summary(),
        "cpu_s": round(cpu, 2),
        "wall_s": round(seconds, 2),
        "times_real_time": round(duration / cpu, 1),
        "peak_mib": round(_peak(), 1),
        "own_mib": round(_peak() - memory, 1),
        "stages": _errors(made, log, truth),
    }


def _resident() -> float:
    """Return the resident memory of this process [MiB]."""
    return psutil.Process().memory_info().rss / 2**20


def _peak() -> float:
    """Return the largest resident memory so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _read(job: SlamJob) -> tuple[ScanLog, _Truth]:
    if job.log is None:
        walls, way = (corridors(job.seed), corridor_route()) if job.corridors else (office(job.seed), route())
        drive: SimulatedDrive = simulate(walls, way, job.seed, sweep=job.sweep)
        return drive.log, _Truth(random_relations(drive.log.stamps, drive.true, RELATIONS_SEED), drive.true)
    path = job.log.with_name(job.log.name.partition(".")[0] + ".relations")
    relations = parse_relations(path.read_text("ascii")) if path.is_file() else None
    return read_scan_log(job.log), _Truth(relations, None)


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
        "ms a scan": f"{1e3 * result['seconds']['tracking'] / max(result['scans'], 1):.2f}",
        "MiB (own)": f"{result['peak_mib']:.0f} ({result['own_mib']:.0f})",
    }


def _with_deviation(errors: dict[str, Any], unit: str) -> str:
    mean = errors.get(f"mean_{unit}", math.nan)
    if math.isnan(mean):
        return ""
    digits = 4 if unit == "m" else 3
    return f"{mean:.{digits}f} ± {errors[f'std_{unit}']:.{digits}f} (max {errors[f'max_{unit}']:.2f})"
