"""Labels while an index is built."""

from collections.abc import Callable

import numpy as np

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT, Integers

FEW = 256
"""Nodes that may be labelled side by side, below which it takes longer to wake threads than to do so."""

FIRST_ROOM = 1 << 16

USUAL = 128
"""Entries of a label for which there is room from the first; memory is taken only as it is used."""

COPIED_A_SLICE = 1 << 20


class LabelPool:
    """Labels, by the rank of their node.

    Attributes
    ----------
    ranks : (n,) int32 array
        How important each corner is; 0 the most.
    hubs, lengths, towards : (m,) int32 arrays
        The entries: hub, how far it is, and the edge towards it.
    begins, ends : (n,) int64 array
        Where the label of a rank lies.
    labelled : int
        How many of the most important corners have labels.
    """

    def __init__(self, ranks: Integers) -> None:
        nodes = len(ranks)
        room = USUAL * nodes + FIRST_ROOM
        self.ranks = ranks
        self.hubs, self.lengths, self.towards = (np.empty(room, np.int32) for _ in range(3))
        self.begins, self.ends = np.zeros((2, nodes), np.int64)
        self.used = self.labelled = 0

    @property
    def room(self) -> int:
        """Return for how many entries there is room."""
        return len(self.hubs)

    def extend(self, room: int, check: Callable[[], None]) -> None:
        """Make room for so many more entries at the end."""
        self.hubs, self.lengths, self.towards = (
            _extended(each, room, check) for each in (self.hubs, self.lengths, self.towards)
        )


def _extended(entries: Integers, room: int, check: Callable[[], None]) -> Integers:
    longer = np.empty(len(entries) + room, np.int32)
    for first in range(0, len(entries), COPIED_A_SLICE):
        check()
        longer[first : min(first + COPIED_A_SLICE, len(entries))] = entries[first : first + COPIED_A_SLICE]
    return longer


def too_long(longest: int) -> InvalidPlanner:
    """Return the error for a way that is longer than a label may tell."""
    return InvalidPlanner(
        f"a way on the map is longer than {longest // STRAIGHT} cells, too long for an index of hub labels; "
        "choose another planner"
    )
