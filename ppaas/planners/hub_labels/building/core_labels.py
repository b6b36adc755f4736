"""Labels of the core: nodes that were not contracted."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE
from ppaas.planners.hub_labels.building.importance import RankedEdges
from ppaas.planners.hub_labels.building.kernels.core_labels import LIVE, POOL, ROOT, add_entries
from ppaas.planners.hub_labels.building.kernels.core_searches import NEXT, QUEUED, SCRATCH, TOO_LONG, search
from ppaas.planners.hub_labels.building.label_pool import FEW, LabelPool, too_long
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR

LEAST_BATCH, MOST_BATCH, NODES_A_SEARCH = 4, 64, 16
"""Limits of the number of nodes searched in one batch, and the number of earlier nodes for each node of a batch. Larger
batches let threads run longer without a barrier, but nodes of a batch do not know each other as hubs."""


class CoreLabels:
    """Labels the core in batches of nodes, the most important first.

    Parameters
    ----------
    pool : LabelPool
        Receives the labels.
    edges : RankedEdges
        Edges of nodes numbered by importance, core nodes first.
    size : int
        Number of core nodes.
    longest : int
        Largest length of a path.
    threads : int
        Maximum number of threads for kernels.
    """

    def __init__(self, pool: LabelPool, edges: RankedEdges, size: int, *, longest: int, threads: int) -> None:
        self._pool, self._edges, self._size, self._longest = pool, edges, size, longest
        self._threads = slots = max(1, threads) if size >= FEW else 1
        self._scratch = np.full((slots, SCRATCH, size), FAR, np.int32)
        self._heaps = np.empty((slots, edges.starts[size] + 1), np.int64)
        self._found = np.empty((slots, LEAST_BATCH * size, 3), np.int32)
        self._capacities, self._from_root = np.zeros(size, np.int32), np.full(MOST_BATCH, FAR, np.int32)
        self._state = np.zeros(4, np.int64)

    def label(self, most_entries: int, check: Callable[[], None]) -> bool:
        """Label the core, and return whether at most ``most_entries`` entries were needed.

        Raises
        ------
        InvalidPlanner
            A path between two nodes is too long.
        """
        first = 0
        while first < self._size and self._state[LIVE] <= most_entries:
            batch = min(max(LEAST_BATCH, first // NODES_A_SEARCH), MOST_BATCH, self._size - first)
            bounds = np.zeros(batch + self._threads, np.int64)
            self._search(first, batch, bounds, check)
            self._add_entries(first, batch, bounds, check)
            first += batch
        self._pool.used, self._pool.labelled = int(self._state[POOL]), self._size
        return bool(self._state[LIVE] <= most_entries)

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

    def _add_entries(self, first: int, batch: int, bounds: Words, check: Callable[[], None]) -> None:
        pool = self._pool
        self._state[ROOT] = 0
        done = False
        while not done:
            check()
            before = self._state.copy()
            done = add_entries(
                first, batch, self._found, bounds,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends, self._capacities,
                self._from_root, self._state, WORK_A_SLICE,
            )  # fmt: skip
            if not done and (self._state == before).all():
                pool.extend(pool.capacity, check)
