"""Measurement of whole robots in a house: goals and waits beside bounds, contacts, and a lift that breaks."""

import statistics
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from typing import NamedTuple

from benchmarks.building.hotel.run import HotelCase, HotelResult, HouseRun
from benchmarks.harness.figures import Figure
from ppaas.buildings.lifts.schedule import levels_of
from ppaas.buildings.lifts.simulated import LiftModel

PART = "hotel"

GOALS_OVER, WAIT_OVER, REROUTED = 1.3, 1.5, 5.0
"""Bars: goals over those of first-come-first-served, mean wait over its bound, and time until no robot is led to a lift
that has broken [s]."""

PASSAGES = ("boarding", "alighting")
"""Phases in which a robot passes the doors of a lift."""

AT_ONCE = 3
"""Number of runs at a time."""


class _Runs(NamedTuple):
    ours: Sequence[HotelResult]
    first: Sequence[HotelResult]
    broken: Sequence[HotelResult]


def measure_hotel(case: HotelCase, seeds: int, advance: Callable[[], None]) -> list[Figure]:
    """Simulate all seeds of a house with and without sharing, and with a lift that breaks after a third of the time."""
    first_come, broken = replace(case, first_come=True), replace(case, breaks_at=case.seconds / 3.0)
    kinds = [kind for kind in (case, first_come, broken) for _ in range(seeds)]
    results = []
    with ProcessPoolExecutor(AT_ONCE, get_context("spawn")) as workers:  # threads of kernels do not survive a fork
        for result in workers.map(_simulate, kinds, list(range(seeds)) * 3):
            results.append(result)
            advance()
    return figures_of(case, results[:seeds], results[seeds : 2 * seeds], results[2 * seeds :])


def figures_of(
    case: HotelCase, ours: Sequence[HotelResult], first: Sequence[HotelResult], broken: Sequence[HotelResult]
) -> list[Figure]:
    """Return the figures of runs: ours, first come first served, and with a lift that breaks."""
    runs = _Runs(ours, first, broken)
    return [*_figures(case, runs), *_safety(runs)]


def _simulate(case: HotelCase, seed: int) -> HotelResult:
    return HouseRun(case, seed).run()


def _figures(case: HotelCase, runs: _Runs) -> Iterator[Figure]:
    goals, others = sum(run.goals for run in runs.ours), sum(run.goals for run in runs.first)
    minutes = f"{case.robots} robots, {case.seconds / 60.0:g} min, {len(runs.ours)} seeds"
    yield Figure(PART, "goals", goals, "", note=minutes)
    yield Figure(PART, "goals, first come first served", others, "", yardstick=True, note="one robot a trip")
    ratio = goals / max(others, 1)
    yield Figure(PART, "goals over first come first served", round(ratio, 3), "", limit=GOALS_OVER, floor=True)
    waits = [wait for run in runs.ours for wait in run.waits]
    wait, bound = statistics.fmean(waits), least_wait(case, runs.ours)
    yield Figure(PART, "mean wait for a lift", round(wait, 1), "s", note=f"at most {max(waits):.0f} s")
    yield Figure(
        PART, "bound of the mean wait", round(bound, 1), "s", yardstick=True,
        note="closed queue: cars always full, passages and drives as they were",
    )  # fmt: skip
    yield Figure(PART, "mean wait over its bound", round(wait / bound, 3), "", limit=WAIT_OVER)
    for phase in PASSAGES:
        mean = statistics.fmean(time for run in runs.ours for time in run.passages[phase])
        yield Figure(PART, f"time of {phase}", round(mean, 1), "s", note="mean, from the order")
    rerouted = max(run.rerouted for run in runs.broken)
    yield Figure(
        PART, "re-routed after a lift breaks", round(rerouted, 1), "s", limit=REROUTED,
        note="until no robot waits for it or drives towards it",
    )  # fmt: skip


def _safety(runs: _Runs) -> Iterator[Figure]:
    every = [run for kind in runs for run in kind]
    nearest = min(run.nearest for run in every)
    yield Figure(PART, "contacts", sum(run.contacts for run in every), "", limit=0.0, note=f"nearest {nearest:.3f} m")
    yield Figure(PART, "robots in shut doors of lifts", sum(run.shut for run in every), "", limit=0.0)
    stood = max(run.stood for run in every)
    yield Figure(
        PART,
        "deadlocks",
        sum(run.deadlocks for run in every),
        "",
        limit=0.0,
        note=f"nobody got on for {stood:.0f} s at most",
    )
    failed = [text for run in every for text in run.failed]
    yield Figure(PART, "goals that were not reached", len(failed), "", limit=0.0, note="; ".join(failed[:2]))
    longest = max(run.longest for run in runs.ours)
    yield Figure(PART, "longest open goal", round(longest, 0), "s", note="both lifts in order")


def least_wait(case: HotelCase, runs: Sequence[HotelResult]) -> float:
    """Return a bound below which no schedule brings the mean wait, with the passages and drives of some runs [s].

    Robots and lifts are a closed queue. A ride takes the passages of its doors, and a share of a trip in a full car; so
    the lifts serve at most so many robots a second, and a robot that neither drives nor rides waits. With few robots it
    waits at least until an idle car has opened.
    """
    model, house = LiftModel(), case.house
    levels = levels_of(house.building).values()
    rises = [abs(one - other) for one in levels for other in levels if one != other]
    trip = statistics.fmean(rises) / model.speed + model.speed / model.acceleration + 2.0 * model.doors
    passages = sum(statistics.fmean(time for run in runs for time in run.passages[phase]) for phase in PASSAGES)
    drive = statistics.fmean(time for run in runs for time in run.drives)
    service = (passages + trip / case.capacity) / len(house.layout.landings)
    return max(case.robots * service - drive - passages - trip, model.doors)
