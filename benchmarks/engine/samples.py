"""Figures of samples of which the worst matter as well."""

import itertools
from collections.abc import Sequence

import numpy as np

from benchmarks.harness.figures import Figure, median_of


def median_and_p99(
    part: str, name: str, samples: Sequence[float], *, limit: float | None = None, note: str = ""
) -> list[Figure]:
    """Return the median of samples [s] and what 99 % of them do not go beyond, both with the limit [ms]."""
    p99 = float(np.percentile(samples, 99, method="higher"))
    return [
        median_of(part, name, samples, limit=limit, note=note),
        Figure(part, f"{name}, p99", round(1e3 * p99, 3), "ms", limit=limit, note=f"of {len(samples)}"),
    ]


def median_and_worst(
    part: str, name: str, samples: Sequence[float], *, limit: float | None, note: str = ""
) -> list[Figure]:
    """Return the median of samples [s] and the worst of them, both with the limit, if any [ms]."""
    return [
        median_of(part, name, samples, limit=limit, note=note),
        Figure(part, f"{name}, worst", round(1e3 * max(samples), 3), "ms", limit=limit, note=f"of {len(samples)}"),
    ]


def served_after(commands: Sequence[float], fault: float) -> float:
    """Return how long after a fault a robot was commanded again [s].

    What was on its way when the fault came is heard a moment later: the longest silence that ends after the fault is
    the one that it made.

    Parameters
    ----------
    commands : sequence of float
        When each was heard, in order, at least one of them before and one after the fault [s].
    fault : float
        When it was [s].
    """
    ends = [(after - before, after) for before, after in itertools.pairwise(commands) if after > fault]
    return max(ends)[1] - fault
