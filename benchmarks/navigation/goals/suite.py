"""All drives of the goals bench, in parallel processes, and their summary."""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.parallel_runs import run_all
from benchmarks.navigation.goals import results_file
from benchmarks.navigation.goals.run import GoalsJob, GoalsResult, drive


def measure(
    jobs: Sequence[GoalsJob], processes: int, done: Callable[[], None], keep: Path | None = None
) -> list[GoalsResult]:
    """Simulate all drives; return the result of each goal, in the order of the jobs.

    Parameters
    ----------
    jobs : sequence of GoalsJob
    processes : int
    done : callable
        Called after each drive.
    keep : Path, optional
        File of results; drives that it contains are not repeated.

    Raises
    ------
    InvalidInput
        The file is not a file of results.
    """
    if keep is None:
        return [result for results in run_all(drive, jobs, processes, done) for result in results]
    known = results_file.read(keep)
    left = [job for job in jobs if results_file.key(job) not in known]
    for _ in range(len(jobs) - len(left)):
        done()
    run_all(partial(_drive_and_keep, keep), left, processes, done)
    known = results_file.read(keep)
    return [result for job in jobs for result in known[results_file.key(job)]]


def _drive_and_keep(path: Path, job: GoalsJob) -> None:
    results_file.append(path, job, drive(job))


def summary(results: Sequence[GoalsResult]) -> dict[str, Any]:
    """Return the summary of all goals; times are means over the reached goals."""
    times = [result.seconds for result in results if result.reached]
    nearest = min(result.nearest for result in results)
    return {
        "goals": len(results),
        "reached": len(times),
        "collisions": sum(result.walls + result.caused + result.suffered for result in results),
        "caused": sum(result.walls + result.caused for result in results),
        "walls": sum(result.walls for result in results),
        "touched_by_people": sum(result.suffered for result in results),
        "mean_seconds": round(float(np.mean(times)), 1) if times else None,
        "metres": round(sum(result.metres for result in results), 1),
        "recoveries": sum(result.recoveries for result in results),
        "nearest_m": round(nearest, 3) if np.isfinite(nearest) else None,
        "failures": dict(Counter(result.outcome for result in results if not result.reached)),
    }
