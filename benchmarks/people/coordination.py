"""Parts ``coordination`` and ``faults``: all runs, in several processes, and runs with bad input, with bars."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.harness.parallel_runs import run_all
from benchmarks.people.options import PeopleOptions
from benchmarks.people.runs.faults import MIRRORS, REPORT_FAULTS
from benchmarks.people.runs.job import PeopleJob, PeopleResult, append_result, check_results, key_of, read_results
from benchmarks.people.runs.run import run

PART = "coordination"

EXACT, FOLLOWED = 0.95, 0.95
"""Least shares of the time with an exact count, and with a robot near the target."""
SWITCHES = 1.0
"""Largest number of identity switches per person and ten minutes."""

Results = Sequence[PeopleResult]


def measure(options: PeopleOptions, done: Callable[[], None]) -> PartResult:
    """Simulate all runs; return the figures of each policy, and a row for each map, number of robots and of people.

    Parameters
    ----------
    options : PeopleOptions
    done : callable
        Called after each run.

    Raises
    ------
    InvalidInput
        The file of results is not one, or cannot be written.
    """
    results = results_of(options.jobs, options.processes, options.keep, done)
    figures = [figure for policy, each in _by(results, _policy) for figure in _figures(policy, each)]
    return PartResult(figures, rows_of(results), msgspec.to_builtins(results))


def results_of(jobs: Sequence[PeopleJob], processes: int, keep: Path | None, done: Callable[[], None]) -> Results:
    """Return the results of runs, in the order of the jobs; those that a file contains are not repeated."""
    if keep is None:
        return run_all(run, jobs, processes, done)
    known = read_results(keep)
    check_results(keep)
    left = [job for job in jobs if key_of(job) not in known]
    for _ in range(len(jobs) - len(left)):
        done()
    run_all(partial(_run_and_keep, keep), left, processes, done)
    known = read_results(keep)
    return [known[key_of(job)] for job in jobs]


def _run_and_keep(path: Path, job: PeopleJob) -> None:
    append_result(path, job, run(job))


# -- figures -----------------------------------------------------------------------------------------------------------


def switches_per_person(results: Results) -> float:
    """Return the number of identity switches per person and ten minutes; 0 without people."""
    person_minutes = sum(result.people * result.simulated / 60.0 for result in results)
    return 10.0 * sum(result.identity_switches for result in results) / person_minutes if person_minutes else 0.0


def _figures(policy: str, results: Results) -> list[Figure]:
    """Return the figures of a policy; those of other policies than the paper's are baselines without bars."""
    baseline = policy != "paper"

    def figure(name: str, samples: Sequence[float], limit: float, unit: str = "", *, floor: bool = False) -> Figure:
        low, high = (round(float(f(samples)), 4) for f in (np.min, np.max))
        return Figure(
            PART, f"{policy}: {name}", round(float(np.mean(samples)), 4), unit, low, high,
            None if baseline else limit, floor=floor, yardstick=baseline, note=f"mean of {len(samples)} runs",
        )  # fmt: skip

    return [
        figure("count exact", [result.count_exact for result in results], EXACT, floor=True),
        figure("identity switches", [switches_per_person([result]) for result in results], SWITCHES, "/person/10 min"),
        figure("target within 3 m", [result.followed_fraction for result in results], FOLLOWED, floor=True),
        figure("flaps", [result.flaps for result in results], 0.0),
        figure("contacts caused", [result.contacts for result in results], 0.0),
        Figure(PART, f"{policy}: handovers", float(np.mean([result.handovers for result in results])), "",
               yardstick=baseline),
        Figure(PART, f"{policy}: HOTA", round(float(np.mean([result.hota for result in results])), 4), "",
               yardstick=baseline, note="TrackEval, similarity 0 at 2 m"),
        Figure(PART, f"{policy}: MOTA", round(float(np.mean([result.mota for result in results])), 4), "",
               yardstick=baseline, note="TrackEval, matches within 1 m"),
    ]  # fmt: skip


def _policy(result: PeopleResult) -> str:
    return result.policy


def _setting(result: PeopleResult) -> tuple[str, int, int, str, str]:
    return result.map, result.robots, result.people, result.policy, result.fault


def _by(results: Results, key: Callable[[PeopleResult], Any]) -> list[tuple[Any, Results]]:
    """Return the results grouped by a key, in the order in which the keys first appear."""
    keys = list(dict.fromkeys(map(key, results)))
    return [(name, list(group)) for name, group in groupby(sorted(results, key=lambda r: keys.index(key(r))), key)]


def rows_of(results: Results) -> list[dict[str, str]]:
    """Return a row for each map, number of robots and of people, policy and fault."""
    return [_row(each) for _, each in _by(results, _setting)]


def _row(results: Results) -> dict[str, str]:
    first = results[0]

    def mean(name: str) -> float:
        return float(np.mean([getattr(result, name) for result in results]))

    return {
        "map": first.map, "robots": str(first.robots), "people": str(first.people), "policy": first.policy,
        "fault": first.fault or "-", "runs": str(len(results)),
        "in view": f"{mean('seen'):.1f}", "exact": f"{mean('count_exact'):.1%}",
        "error": f"{mean('count_error_mean'):.3f}", "switches": f"{switches_per_person(results):.2f}",
        "within 3 m": f"{mean('followed_fraction'):.1%}", "handovers": f"{mean('handovers'):.1f}",
        "flaps": f"{sum(result.flaps for result in results)}",
        "contacts": f"{sum(result.contacts for result in results)}",
        "HOTA": f"{mean('hota'):.3f}", "MOTA": f"{mean('mota'):.3f}",
        "cycle p99": f"{1e3 * max(result.cycle_p99 for result in results):.1f} ms",
        "× real time": f"{sum(r.simulated for r in results) / max(sum(r.taken for r in results), 1e-9):.1f}",
    }  # fmt: skip


# -- bad input of one robot or of the place, and its effect on the group -----------------------------------------------

FAULTS = "faults"

FAULTY_ROBOTS, FAULTY_PEOPLE, CROWD = 4, 8, 40
"""Numbers of robots and people of the runs, and of people in a crowd."""
FAULTY_MINUTES, QUICK_FAULTY_MINUTES = 2.0, 0.5
"""Simulated time of each run, and of each quick one [min]."""
CROWDED = "crowd"


def measure_faults(options: PeopleOptions, done: Callable[[], None]) -> PartResult:
    """Return the figures of a run with each fault, beside one without, by the rule of the paper.

    Parameters
    ----------
    options : PeopleOptions
        Its first job sets the map, the detections and the size of images.
    done : callable
        Called after each run.
    """
    results = results_of(faulty_jobs(options), options.processes, options.keep, done)
    figures = [figure for result in results for figure in _fault_figures(result)]
    return PartResult(figures, rows_of(results), msgspec.to_builtins(results))


def faulty_jobs(options: PeopleOptions) -> Sequence[PeopleJob]:
    """Return the runs."""
    minutes = QUICK_FAULTY_MINUTES if options.quick else FAULTY_MINUTES
    sound = replace(
        options.jobs[0], robots=FAULTY_ROBOTS, people=FAULTY_PEOPLE, minutes=minutes, policy="paper", seed=options.seed
    )
    faulty = [replace(sound, fault=fault) for fault in (*REPORT_FAULTS, MIRRORS)]
    return [sound, *faulty, replace(sound, people=CROWD, fault=CROWDED)]


def _fault_figures(result: PeopleResult) -> list[Figure]:
    """Return the figures of a run; that without a fault is the baseline."""
    name, sound = result.fault or "no fault", not result.fault
    note = f"{result.seen:.1f} in view, mean error {result.count_error_mean:.2f}"
    return [
        Figure(FAULTS, f"{name}: count exact", result.count_exact, "", limit=None if sound else EXACT,
               floor=True, yardstick=sound, note=note),
        Figure(FAULTS, f"{name}: flaps", result.flaps, "", limit=None if sound else 0.0, yardstick=sound),
    ]  # fmt: skip
