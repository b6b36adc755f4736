"""All runs of the BARN bench, in parallel processes, and their summary."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.harness.parallel_runs import run_all
from benchmarks.navigation.barn.run import BarnJob, BarnResult, drive
from benchmarks.navigation.barn.worlds import BarnWorld


@dataclass(frozen=True, slots=True)
class BarnOptions:
    """Settings of the BARN bench.

    Parameters
    ----------
    runs : int
        Number of runs in each world.
    planner, noise : str
        Local planner and noise level, as in `benchmarks.navigation.barn.run.BarnJob`.
    seed : int
        Seed of all noise.
    jobs : int
        Number of processes.
    """

    runs: int
    planner: str
    noise: str
    seed: int
    jobs: int


def measure(worlds: Sequence[BarnWorld], options: BarnOptions, done: Callable[[], None]) -> list[BarnResult]:
    """Simulate all runs; return the results in the order of worlds and runs.

    Parameters
    ----------
    worlds : sequence of BarnWorld
    options : BarnOptions
    done : callable
        Called after each run.
    """
    return run_all(drive, jobs_of(worlds, options), options.jobs, done)


def jobs_of(worlds: Sequence[BarnWorld], options: BarnOptions) -> list[BarnJob]:
    """Return all runs, in the order of worlds and runs."""
    return [
        BarnJob(world, options.planner, options.noise, options.seed, run)
        for world in worlds
        for run in range(options.runs)
    ]


def summary(results: Sequence[BarnResult]) -> dict[str, Any]:
    """Return the summary of runs: shares by outcome, and means.

    ``metric`` is the mean score. ``at_over_ot`` is the mean ratio of the duration to the time of the reference path at
    full speed, over successful runs. ``min_clearance`` is the smallest clearance of any run [m].
    """
    successes = [result for result in results if result.outcome == "success"]
    times = [result.seconds / result.best_time for result in successes]
    return {
        "worlds": len({result.world for result in results}),
        "runs": len(results),
        **{name: _share(results, name) for name in ("success", "collision", "timeout")},
        "metric": round(float(np.mean([result.score for result in results])), 4),
        "at_over_ot": round(float(np.mean(times)), 3) if times else None,
        "min_clearance": round(min(result.clearance for result in results), 4),
    }


def _share(results: Sequence[BarnResult], outcome: str) -> float:
    return round(sum(result.outcome == outcome for result in results) / len(results), 4)
