"""Figures of samples: median with 99th percentile or maximum."""

import itertools
from collections.abc import Sequence

import numpy as np

from benchmarks.harness.figures import Figure, median_of


def median_and_p99(
    part: str, name: str, samples: Sequence[float], *, limit: float | None = None, note: str = ""
) -> list[Figure]:
    """Return the median and the 99th percentile of samples [s], both with the limit [ms]."""
    p99 = float(np.percentile(samples, 99, method="higher"))
    return [
        median_of(part, name, samples, limit=limit, note=note),
        Figure(part, f"{name}, p99", round(1e3 * p99, 3), "ms", limit=limit, note=f"of {len(samples)}"),
    ]


def median_and_worst(
    part: str, name: str, samples: Sequence[float], *, limit: float | None, note: str = ""
) -> list[Figure]:
    """Return the median and the maximum of samples [s], both with the limit, if any [ms]."""
    return [
        median_of(part, name, samples, limit=limit, note=note),
        Figure(part, f"{name}, worst", round(1e3 * max(samples), 3), "ms", limit=limit, note=f"of {len(samples)}"),
    ]


def served_after(commands: Sequence[float], fault: float) -> float:
    """Return the time from a fault until a robot received commands again [s].

    Commands in flight still arrive after the fault, so the effect of the fault is the longest gap that ends after it.

    Parameters
    ----------
    commands : sequence of float
        Arrival times in order [s], at least one of them before and one after the fault.
    fault : float
        Time of the fault [s].
    """
    ends = [(after - before, after) for before, after in itertools.pairwise(commands) if after > fault]
    return max(ends)[1] - fault
