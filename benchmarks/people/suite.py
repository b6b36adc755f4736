"""Runs the parts of ``ppaas bench people``."""

from collections.abc import Callable, Sequence

from rich.progress import Progress

from benchmarks.harness.figures import PartResult
from benchmarks.harness.parallel_runs import run_all
from benchmarks.people import bandwidth, coordinator, detector, legs
from benchmarks.people.options import PeopleOptions
from ppaas.errors import InvalidInput, PPaaSError

RUNS = ("coordination", "faults")
"""The parts that have a process for each of their runs."""

PARTS: dict[str, Callable[[PeopleOptions], PartResult]] = {
    "detector": detector.measure,
    "legs": legs.measure,
    "coordinator": coordinator.measure,
    "bandwidth": bandwidth.measure,
}
"""The other parts; each has one process."""

NAMES = (*RUNS, *PARTS)
"""Names of all parts, in the order in which they run."""


def measure(options: PeopleOptions, only: Sequence[str], progress: Progress) -> dict[str, PartResult]:
    """Return the results of the chosen parts; of all, if none is chosen. The others go on if one fails.

    Raises
    ------
    InvalidInput
        A file cannot be read.
    """
    chosen = [name for name in NAMES if not only or name in only]
    task = progress.add_task("measuring", total=len(chosen) + sum(_number(name, options) for name in chosen))
    results = {}
    for name in chosen:
        progress.update(task, description=name)
        try:
            results[name] = _measure(name, options, lambda: progress.advance(task))
        except InvalidInput:
            raise
        except PPaaSError as error:
            results[name] = PartResult.failed(name, error)
        progress.advance(task)
    return results


def _number(name: str, options: PeopleOptions) -> int:
    if name == "faults":
        from benchmarks.people import coordination  # noqa: PLC0415 - see below

        return len(coordination.faulty_jobs(options))
    return len(options.jobs) if name in RUNS else 0


def _measure(name: str, options: PeopleOptions, done: Callable[[], None]) -> PartResult:
    if name in RUNS:
        # Imported only here, so that the other parts load neither clones nor TrackEval.
        from benchmarks.people import coordination  # noqa: PLC0415

        measure_runs = coordination.measure_faults if name == "faults" else coordination.measure
        return measure_runs(options, done)
    (result,) = run_all(PARTS[name], [options], 1, lambda: None, fresh=True)
    return result
