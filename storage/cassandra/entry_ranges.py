"""Ranges of the numbers of log entries, as they are removed together."""

from collections.abc import Iterable, Sequence

Range = tuple[int, int]
"""Two numbers: the ends of a run, or the bounds of a gap."""


def entry_runs(numbers: Iterable[int]) -> list[Range]:
    """Return the runs of successive numbers as first and last number, in ascending order."""
    runs: list[Range] = []
    for number in sorted(set(numbers)):
        if runs and number == runs[-1][1] + 1:
            runs[-1] = runs[-1][0], number
        else:
            runs.append((number, number))
    return runs


def joined(runs: Sequence[Range], beside: Sequence[Range]) -> list[Range]:
    """Return the gaps that runs leave, as exclusive bounds; runs with no other entry between them leave one gap.

    Parameters
    ----------
    runs : sequence of Range
        Runs of numbers that are removed (``entry_runs``).
    beside : sequence of Range
        The next stored number below and above each run, which may be removed too.
    """
    gaps: list[Range] = []
    for at, (low, high) in enumerate(beside):
        if at and low == runs[at - 1][1]:  # nothing is left between this run and the one before
            gaps[-1] = gaps[-1][0], high
        else:
            gaps.append((low, high))
    return gaps
