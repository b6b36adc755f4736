"""Memory for the labels of an index under construction."""

from collections.abc import Callable

import numpy as np

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT, Integers

FEW = 256
"""Nodes below which waking threads takes longer than labelling them."""

FIRST_CAPACITY = 1 << 16
"""Initial capacity in addition to `USUAL_LABEL_ENTRIES` [entries]."""

USUAL_LABEL_ENTRIES = 128
"""Initial capacity per label [entries]. Memory is committed only as it is used."""

COPIED_A_SLICE = 1 << 20
"""Entries copied between two calls of ``check``."""


class LabelPool:
    """Labels by the rank of their corner.

    Attributes
    ----------
    ranks : (n,) int32 array
        Rank of each corner; 0 is the most important.
    hubs, lengths, towards : (m,) int32 arrays
        The entries: hub, distance, and the edge towards the hub.
    begins, ends : (n,) int64 arrays
        Range of the label of each rank.
    used : int
        Number of entries in use or given to slots.
    labelled : int
        Number of labelled corners; they are the most important ones.
    """

    def __init__(self, ranks: Integers) -> None:
        nodes = len(ranks)
        capacity = USUAL_LABEL_ENTRIES * nodes + FIRST_CAPACITY
        self.ranks = ranks
        self.hubs, self.lengths, self.towards = (np.empty(capacity, np.int32) for _ in range(3))
        self.begins, self.ends = np.zeros((2, nodes), np.int64)
        self.used = self.labelled = 0

    @property
    def capacity(self) -> int:
        """Capacity [entries]."""
        return len(self.hubs)

    def extend(self, capacity: int, check: Callable[[], None]) -> None:
        """Add capacity at the end."""
        self.hubs, self.lengths, self.towards = (
            _extended(each, capacity, check) for each in (self.hubs, self.lengths, self.towards)
        )


def _extended(entries: Integers, capacity: int, check: Callable[[], None]) -> Integers:
    longer = np.empty(len(entries) + capacity, np.int32)
    for first in range(0, len(entries), COPIED_A_SLICE):
        check()
        longer[first : min(first + COPIED_A_SLICE, len(entries))] = entries[first : first + COPIED_A_SLICE]
    return longer


def too_long(longest: int) -> InvalidPlanner:
    """Return the error for a path that is longer than labels can represent."""
    return InvalidPlanner(
        f"the map has a path of more than {longest // STRAIGHT} cells, too long for an index of hub labels; "
        "choose another planner, such as jps or dijkstra"
    )
