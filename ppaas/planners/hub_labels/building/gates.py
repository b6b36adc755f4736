"""The fringe of an index: corners without labels, and over which corners with labels ways leave it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ppaas.planners.hub_labels.building.importance import RankedEdges
from ppaas.planners.hub_labels.building.kernels.gates import BEGIN, END, NEXT, open_gates
from ppaas.planners.hub_labels.building.label_pool import FEW, LabelPool
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers

USUAL = 24
"""Gates of a corner for which there is room from the first; memory is taken only as it is used."""

WORK_A_SLICE = 1 << 16
WINDOW = 1 << 14


@dataclass(frozen=True, slots=True)
class Fringe:
    """The gates of all corners, by rank; those with labels have none.

    Parameters
    ----------
    gates, lengths : (m,) int32 arrays
        As `kernels.gates` has them.
    begins, ends : (n,) int64 arrays
    local : (edges,) int64 array
        One for each edge of the contracted graph that is local.
    boxes : (n, 4) int32 array
    """

    gates: Integers
    lengths: Integers
    begins: Words
    ends: Words
    local: Words
    boxes: Integers


def open_fringe(
    pool: LabelPool, edges: RankedEdges, levels: Integers, places: Integers, *, threads: int, check: Callable[[], None]
) -> Fringe:
    """Find the gates of all corners without labels.

    Parameters
    ----------
    pool : LabelPool
    edges : RankedEdges
        Of the contracted graph, by rank.
    levels : (n,) int32 array
        On which level each rank was contracted; there are no edges within a level.
    places : (n, 2) int32 array
        Row and column of each rank.
    threads, check
        As for `assembly.build_index`.
    """
    nodes, slots = len(pool.ranks), max(1, threads)
    rest = np.arange(pool.labelled, nodes, dtype=np.int32)
    fringe = _Growing(nodes, len(rest), len(edges.to))
    scratch = np.full((4 * slots, pool.labelled), FAR, np.int32)
    spots, heaps = np.full((2 * slots, nodes), FAR, np.int32), np.empty((slots, nodes), np.int64)
    windows = np.zeros((slots, 3), np.int64)
    for level in np.split(rest, np.flatnonzero(np.diff(levels[rest])) + 1):
        usable = threads if len(level) >= FEW else 1
        windows[:, NEXT] = np.arange(slots)
        while (windows[:, NEXT] < len(level)).any():
            check()
            before = windows[:, NEXT].copy()
            open_gates(
                level, pool.labelled, edges.starts, edges.to, edges.lengths, places,
                pool.hubs, pool.lengths, pool.begins, pool.ends,
                fringe.gates, fringe.lengths, fringe.begins, fringe.ends, fringe.local, fringe.boxes,
                scratch, spots, heaps, windows, WORK_A_SLICE, usable,
            )  # fmt: skip
            for slot in np.flatnonzero((windows[:, NEXT] == before) & (before < len(level))):
                windows[slot, BEGIN], windows[slot, END] = fringe.window(pool.labelled)
    return fringe.done(edges)


class _Growing:
    def __init__(self, nodes: int, fringe: int, edges: int) -> None:
        self.gates, self.lengths = np.empty((2, USUAL * fringe + WINDOW), np.int32)
        self.begins, self.ends = np.zeros((2, nodes), np.int64)
        self.local = np.zeros(edges, np.int64)
        self.boxes = np.zeros((nodes, 4), np.int32)
        self._used = 0

    def window(self, least: int) -> tuple[int, int]:
        """Return where there is room for some gates more."""
        begin, end = self._used, self._used + WINDOW + least
        if end > len(self.gates):
            more = np.empty(max(WINDOW + least, len(self.gates) // 2), np.int32)
            self.gates, self.lengths = np.concatenate((self.gates, more)), np.concatenate((self.lengths, more))
        self._used = end
        return begin, end

    def done(self, edges: RankedEdges) -> Fringe:
        local = np.zeros(int(edges.ids.max(initial=-1)) + 1, np.int64)
        local[edges.ids] = self.local
        return Fringe(self.gates, self.lengths, self.begins, self.ends, local, self.boxes)
