"""Fringe of an index: corners without labels, and the labelled corners (gates) through which paths leave it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ppaas.planners.hub_labels.building.importance import RankedEdges
from ppaas.planners.hub_labels.building.kernels.gates import BEGIN, END, NEXT, find_gates
from ppaas.planners.hub_labels.building.labels import FEW, LabelPool
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers

USUAL_GATES = 24
"""Initial capacity for gates per corner. Memory is committed only as it is used."""

WORK_A_SLICE = 1 << 16
"""Work between two calls of ``check``, about one millisecond."""

WINDOW = 1 << 14
"""Gates that a slot gets space for at once."""


@dataclass(frozen=True, slots=True)
class Fringe:
    """Gates of all corners, by rank; labelled corners have none.

    Parameters
    ----------
    gates, lengths : (m,) int32 arrays
        Gates and their distances, as in `kernels.gates`.
    begins, ends : (n,) int64 arrays
        Range of the gates of each corner.
    local : (edges,) int64 array
        1 for each local edge of the contracted graph, else 0.
    boxes : (n, 4) int32 array
        Bounding rectangle of the corners that each corner reaches over local edges.
    """

    gates: Integers
    lengths: Integers
    begins: Words
    ends: Words
    local: Words
    boxes: Integers


def find_fringe(
    pool: LabelPool,
    edges: RankedEdges,
    levels: Integers,
    positions: Integers,
    *,
    threads: int,
    check: Callable[[], None],
) -> Fringe:
    """Find the gates of all corners without labels.

    Parameters
    ----------
    pool : LabelPool
        The labels.
    edges : RankedEdges
        Edges of the contracted graph, by rank.
    levels : (n,) int32 array
        Contraction level of each rank. There are no edges within a level.
    positions : (n, 2) int32 array
        Row and column of each rank.
    threads, check
        As for `assembly.build_index`.
    """
    nodes, slots = len(pool.ranks), max(1, threads)
    unlabelled = np.arange(pool.labelled, nodes, dtype=np.int32)
    fringe = _FringeBuilder(nodes, len(unlabelled), len(edges.to))
    scratch = np.full((4 * slots, pool.labelled), FAR, np.int32)
    records, heaps = np.full((2 * slots, nodes), FAR, np.int32), np.empty((slots, nodes), np.int64)
    windows = np.zeros((slots, 3), np.int64)
    for level in np.split(unlabelled, np.flatnonzero(np.diff(levels[unlabelled])) + 1):
        usable = threads if len(level) >= FEW else 1
        windows[:, NEXT] = np.arange(slots)
        while (windows[:, NEXT] < len(level)).any():
            check()
            before = windows[:, NEXT].copy()
            find_gates(
                level, pool.labelled, edges.starts, edges.to, edges.lengths, positions,
                pool.hubs, pool.lengths, pool.begins, pool.ends,
                fringe.gates, fringe.lengths, fringe.begins, fringe.ends, fringe.local, fringe.boxes,
                scratch, records, heaps, windows, WORK_A_SLICE, usable,
            )  # fmt: skip
            for slot in np.flatnonzero((windows[:, NEXT] == before) & (before < len(level))):
                windows[slot, BEGIN], windows[slot, END] = fringe.window(pool.labelled)
    return fringe.done(edges)


class _FringeBuilder:
    def __init__(self, nodes: int, fringe: int, edges: int) -> None:
        self.gates, self.lengths = np.empty((2, USUAL_GATES * fringe + WINDOW), np.int32)
        self.begins, self.ends = np.zeros((2, nodes), np.int64)
        self.local = np.zeros(edges, np.int64)
        self.boxes = np.zeros((nodes, 4), np.int32)
        self._used = 0

    def window(self, needed: int) -> tuple[int, int]:
        """Return the range of free space for more gates."""
        begin, end = self._used, self._used + WINDOW + needed
        if end > len(self.gates):
            more = np.empty(max(WINDOW + needed, len(self.gates) // 2), np.int32)
            self.gates, self.lengths = np.concatenate((self.gates, more)), np.concatenate((self.lengths, more))
        self._used = end
        return begin, end

    def done(self, edges: RankedEdges) -> Fringe:
        """Return the fringe, with local edges by edge number."""
        local = np.zeros(int(edges.ids.max(initial=-1)) + 1, np.int64)
        local[edges.ids] = self.local
        return Fringe(self.gates, self.lengths, self.begins, self.ends, local, self.boxes)
