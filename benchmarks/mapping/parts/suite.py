"""Runs the parts of ``ppaas bench slam``, each in its own process, and draws the chart of stages."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any

import msgspec
import uvloop
from rich.console import Console
from rich.progress import Progress

from benchmarks.harness.figures import PartResult
from benchmarks.harness.parallel_runs import run_all
from benchmarks.mapping.parts import graphs, lifelong, logs, merging, pairs, steps, volumes
from benchmarks.mapping.parts.part import SlamOptions
from benchmarks.service import map_transfer, suite
from ppaas.errors import InvalidInput, PPaaSError
from robots.cli import event_loop
from robots.pictures.line_chart import Axis, Line, write_chart


def measure_push(_options: SlamOptions) -> PartResult:
    """Measure the part ``push`` of ``ppaas bench service``."""
    with Progress(console=Console(stderr=True, quiet=True), disable=True) as progress:
        options = suite.ServiceOptions((map_transfer.PUSH,))
        figures = event_loop.run(suite.measure(options, progress), uvloop.new_event_loop)
    return PartResult(figures, [], msgspec.to_builtins(figures))


PARTS: dict[str, Callable[[SlamOptions], PartResult]] = {
    "steps": steps.measure,
    "graphs": graphs.measure,
    "merging": merging.measure,
    "pairs": pairs.measure,
    "lifelong": lifelong.measure,
    "volume": volumes.measure,
    "push": measure_push,
}
"""Parts beside ``logs``, which has a process for each log."""

NAMES = ("logs", *PARTS)
"""Names of all parts, in the order in which they run."""


def measure(options: SlamOptions, only: Sequence[str], progress: Progress) -> dict[str, PartResult]:
    """Return the results of the chosen parts; of all, if none is chosen. The others go on if one fails.

    Raises
    ------
    InvalidInput
        There is no log to map, or a file cannot be read.
    """
    options.check()
    chosen = [name for name in NAMES if not only or name in only]
    jobs = len(logs.jobs_of(options)) if "logs" in chosen else 0
    task = progress.add_task("measuring", total=jobs + len(chosen))
    results = {}
    with tempfile.TemporaryDirectory(prefix="ppaas-slam-") as made:
        options = replace(options, folder=Path(made))
        for name in chosen:
            progress.update(task, description=name)
            try:
                if name == "logs":
                    results[name] = logs.measure(options, lambda: progress.advance(task))
                else:
                    (results[name],) = run_all(PARTS[name], [options], 1, lambda: None, fresh=True)
            except InvalidInput:
                raise
            except PPaaSError as error:
                results[name] = PartResult.failed(name, error)
            progress.advance(task)
    return results


# -- chart of the error and the time of mapping after each stage -------------------------------------------------------

STAGES = {
    "tracking": ("points", "tracking"),
    "closures": ("closures", "solver"),
    "refinement": ("refinement",),
    "polish": ("polish",),
}
"""Parts of the time of each stage."""


def write_stages(path: Path, results: list[dict[str, Any]]) -> None:
    """Write the chart of the logs with true relations to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    lines = [Line(result["log"], points) for result in results if (points := _points(result))]
    title = "Error after tracking, closures, refinement and polish"
    write_chart(path, title, lines, Axis("CPU time [s]"), Axis("mean error of the relations [m]", logarithmic=True))


def _points(result: dict[str, Any]) -> list[tuple[float, float]]:
    """Return the CPU time [s] and the error [m] after each stage; nothing for a log without relations."""
    # The parts are timed by the clock, of which other work on the computer takes a share.
    share = result["cpu_s"] / result["wall_s"]
    times = accumulate(share * sum(result["seconds"][part] for part in parts) for parts in STAGES.values())
    errors = [result["stages"][stage].get("mean_m") for stage in STAGES]
    return [(seconds, error) for seconds, error in zip(times, errors, strict=True) if error]
