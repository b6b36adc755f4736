"""Part ``logs``: errors, false closures, speed and memory of mapping recorded and simulated logs."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from benchmarks.harness.figures import Figure
from benchmarks.harness.parallel_runs import run_all
from benchmarks.harness.parts import PartResult
from benchmarks.mapping.parts import log_run
from benchmarks.mapping.parts.log_run import SlamJob
from benchmarks.mapping.parts.part import SlamOptions
from benchmarks.mapping.worlds import CORRIDORS, EQUAL_CORRIDORS, LABORATORY
from ppaas.errors import InvalidInput

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
    results = run_all(partial(log_run.run, folder=options.folder), jobs, options.jobs, done, fresh=True)
    figures = [figure for result in results for figure in figures_of(result)]
    return PartResult(figures, [log_run.row(result) for result in results], results)


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
    yield from _errors(name, list(result["stages"].values())[-1], bars)
    if result["false_closures"] is not None:
        count = result["false_closures"]
        note = f"of {count['judged']} edges whose truth is known, {count['edges']} in all"
        yield Figure("false closures", f"{name}: over 0.5 m", count["false"], "", limit=0.0, note=note)
    if result["wrong_cells"] is not None:
        share = round(100.0 * result["wrong_cells"], 4)
        yield Figure("map", f"{name}: wrong cells", share, "%", limit=bars.wrong_cells, note="of the known ones")
    yield from _speed(name, result, bars)
    yield from _memory(name, result, bars)


def _errors(name: str, errors: dict[str, Any], bars: Bars) -> Iterator[Figure]:
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
