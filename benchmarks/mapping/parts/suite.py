"""Runs the parts of ``ppaas bench slam``, each in a process of its own."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from rich.progress import Progress

from benchmarks.harness.parallel_runs import run_all
from benchmarks.harness.parts import PartResult
from benchmarks.mapping.parts import graphs, hours, logs, merging, pairs, push, steps, volumes
from benchmarks.mapping.parts.part import SlamOptions
from ppaas.errors import InvalidInput, PPaaSError

PARTS: dict[str, Callable[[SlamOptions], PartResult]] = {
    "steps": steps.measure,
    "graphs": graphs.measure,
    "merging": merging.measure,
    "pairs": pairs.measure,
    "lifelong": hours.measure,
    "volume": volumes.measure,
    "push": push.measure,
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
