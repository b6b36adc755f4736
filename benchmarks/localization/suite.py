"""All runs of the localization bench, in parallel processes, and their summary."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.harness.parallel_runs import run_all
from benchmarks.localization.run import LocalizationJob, LocalizationResult, drive

WITHIN = 10.0
"""Distance within which a robot should be found [m]."""


def measure(jobs: Sequence[LocalizationJob], processes: int, done: Callable[[], None]) -> list[LocalizationResult]:
    """Simulate all runs; return the results in the order of the jobs. ``done`` is called after each run."""
    return run_all(drive, jobs, processes, done)


def summary(results: Sequence[LocalizationResult]) -> dict[str, Any]:
    """Return the summary of all runs; errors are those of runs that were not lost, and null if all were."""
    held = [result for result in results if not result.lost]
    ways = [result.found for result in results]
    found = [way for way in ways if way is not None]
    return {
        "runs": len(results),
        "metres": round(sum(result.metres for result in results), 1),
        "error_cm": _mean([100.0 * result.error for result in held]),
        "error_deg": _mean([math.degrees(result.turn_error) for result in held]),
        "worst_cm": round(100.0 * max((result.worst for result in held), default=0.0), 1) if held else None,
        "worst_deg": round(math.degrees(max(result.worst_turn for result in held)), 1) if held else None,
        "lost": sum(result.lost for result in results),
        "found_within_10_m": round(sum(way <= WITHIN for way in found) / len(results), 3),
        "median_found_m": round(float(np.median(found)), 2) if found else None,
        "update_ms": _mean([1e3 * result.update for result in results]),
    }


def _mean(values: Sequence[float]) -> float | None:
    return round(float(np.mean(values)), 3) if values else None
