"""Sizes of the robots of the traffic: the cells of a map depend on them."""

from collections.abc import Sequence

import numpy as np

from ppaas.fleet.metric_roadmap import MetricRoadmap

MOST_SIZES = 3
"""Largest number of sizes that are told apart; of more, robots count as large as the next larger ones."""


def with_size(radii: Sequence[float], radius: float) -> tuple[float, ...]:
    """Return radii in ascending order together with another one, at most `MOST_SIZES` [m].

    The smallest one and the largest one are always among them.
    """
    every = sorted({*radii, radius})
    return (*every[:1], *every[1:][1 - MOST_SIZES :])


def is_same(one: MetricRoadmap, other: MetricRoadmap) -> bool:
    """Return whether two roadmaps have the same cells, moves and barred cells for all that drive on the first one."""
    if one.spacing != other.spacing or not np.array_equal(one.centres, other.centres):
        return False
    same = np.array_equal(one.roadmap.neighbours, other.roadmap.neighbours)
    return same and not other.roadmap.barred.any()
