"""The labels of the core."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE
from ppaas.planners.hub_labels.building.importance import RankedEdges
from ppaas.planners.hub_labels.building.kernels.core_labels import LIVE, POOL, ROOT, keep
from ppaas.planners.hub_labels.building.kernels.core_searches import NEXT, QUEUED, SCRATCH, TOO_LONG, search
from ppaas.planners.hub_labels.building.label_pool import FEW, LabelPool, too_long
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR

LEAST_BATCH, MOST_BATCH, NODES_A_SEARCH = 4, 64, 16
"""From how many nodes of the core it is searched at a time: one in so many of those before, which are hubs already.
The more, the longer threads go without waiting for each other; but they do not know each other as hubs."""


class CoreLabels:
    """Labels the core, a batch of nodes after the other, the most important first.

    Parameters
    ----------
    pool : LabelPool
        Takes the labels.
    edges : RankedEdges
        Of nodes numbered by their importance, those of the core first.
    size : int
        Nodes of the core.
    longest : int
        How long a way may be.
    threads : int
        Most threads that kernels may use.
    """

    def __init__(self, pool: LabelPool, edges: RankedEdges, size: int, *, longest: int, threads: int) -> None:
        self._pool, self._edges, self._size, self._longest = pool, edges, size, longest
        self._threads = slots = max(1, threads) if size >= FEW else 1
        self._scratch = np.full((slots, SCRATCH, size), FAR, np.int32)
        self._heaps = np.empty((slots, edges.starts[size] + 1), np.int64)
        self._found = np.empty((slots, LEAST_BATCH * size, 3), np.int32)
        self._rooms, self._of_root = np.zeros(size, np.int32), np.full(MOST_BATCH, FAR, np.int32)
        self._state = np.zeros(4, np.int64)

    def label(self, room: int, check: Callable[[], None]) -> bool:
        """Label all of it, and return whether there is room for as many entries as that takes.

        Raises
        ------
        InvalidPlanner
            A way between two nodes is too long.
        """
        first = 0
        while first < self._size and self._state[LIVE] <= room:
            batch = min(max(LEAST_BATCH, first // NODES_A_SEARCH), MOST_BATCH, self._size - first)
            bounds = np.zeros(batch + self._threads, np.int64)
            self._search(first, batch, bounds, check)
            self._keep(first, batch, bounds, check)
            first += batch
        self._pool.used, self._pool.labelled = int(self._state[POOL]), self._size
        return bool(self._state[LIVE] <= room)

    def _search(self, first: int, batch: int, bounds: Words, check: Callable[[], None]) -> None:
        edges, pool = self._edges, self._pool
        states = np.zeros((self._threads, 5), np.int64)
        states[:, NEXT], states[:, QUEUED] = np.arange(self._threads), -1
        while (states[:, NEXT] < batch).any():
            check()
            before = states.copy()
            search(
                first, batch, edges.starts, edges.to, edges.lengths, edges.ids,
                pool.hubs, pool.lengths, pool.begins, pool.ends,
                self._scratch, self._heaps, self._found, bounds, states,
                self._longest, WORK_A_SLICE, self._threads,
            )  # fmt: skip
            if states[:, TOO_LONG].any():
                raise too_long(self._longest)
            if (states == before).all():
                self._found = np.pad(self._found, ((0, 0), (0, self._found.shape[1]), (0, 0)))

    def _keep(self, first: int, batch: int, bounds: Words, check: Callable[[], None]) -> None:
        pool = self._pool
        self._state[ROOT] = 0
        done = False
        while not done:
            check()
            before = self._state.copy()
            done = keep(
                first, batch, self._found, bounds,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends, self._rooms,
                self._of_root, self._state, WORK_A_SLICE,
            )  # fmt: skip
            if not done and (self._state == before).all():
                pool.extend(pool.room, check)
