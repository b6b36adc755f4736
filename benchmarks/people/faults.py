"""Part ``faults``: bad input of one robot or of the place, and its effect on the group."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import msgspec

from benchmarks.harness.figures import Figure
from benchmarks.harness.parts import PartResult
from benchmarks.people import coordination
from benchmarks.people.options import PeopleOptions
from benchmarks.people.runs.faults import MIRRORS, REPORT_FAULTS
from benchmarks.people.runs.job import PeopleJob, PeopleResult

PART = "faults"

ROBOTS, PEOPLE, CROWD = 4, 8, 40
"""Numbers of robots and people of the runs, and of people in a crowd."""
MINUTES, QUICK = 2.0, 0.5
"""Simulated time of each run, and of each quick one [min]."""
CROWDED = "crowd"


def measure(options: PeopleOptions, done: Callable[[], None]) -> PartResult:
    """Return the figures of a run with each fault, beside one without, by the rule of the paper.

    Parameters
    ----------
    options : PeopleOptions
        The map, the detections and the size of images are those of its first job.
    done : callable
        Called after each run.
    """
    results = coordination.results_of(jobs_of(options), options.processes, options.keep, done)
    figures = [figure for result in results for figure in _figures(result)]
    return PartResult(figures, coordination.rows_of(results), msgspec.to_builtins(results))


def jobs_of(options: PeopleOptions) -> Sequence[PeopleJob]:
    """Return the runs."""
    minutes = QUICK if options.quick else MINUTES
    sound = replace(options.jobs[0], robots=ROBOTS, people=PEOPLE, minutes=minutes, policy="paper", seed=options.seed)
    faulty = [replace(sound, fault=fault) for fault in (*REPORT_FAULTS, MIRRORS)]
    return [sound, *faulty, replace(sound, people=CROWD, fault=CROWDED)]


def _figures(result: PeopleResult) -> list[Figure]:
    """Return the figures of a run; that without a fault is the baseline."""
    name, sound = result.fault or "no fault", not result.fault
    note = f"{result.seen:.1f} in view, mean error {result.count_error_mean:.2f}"
    return [
        Figure(PART, f"{name}: count exact", result.count_exact, "", limit=None if sound else coordination.EXACT,
               floor=True, yardstick=sound, note=note),
        Figure(PART, f"{name}: flaps", result.flaps, "", limit=None if sound else 0.0, yardstick=sound),
    ]  # fmt: skip
