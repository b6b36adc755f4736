"""Labels of all corners, in the order of their importance: first the core's, then the contracted corners'."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE, ContractedGraph
from ppaas.planners.hub_labels.building.importance import RankedEdges, edges_of, order_core
from ppaas.planners.hub_labels.building.kernels.core_labels import LIVE, POOL, ROOT, add_entries
from ppaas.planners.hub_labels.building.kernels.core_searches import NEXT, QUEUED, SCRATCH, TOO_LONG, search
from ppaas.planners.hub_labels.building.kernels.label_merging import merge
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT, Integers

# -- memory for the labels under construction --------------------------------------------------------------------------

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


# -- labels of the core: nodes that were not contracted ----------------------------------------------------------------

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


# -- labels of all corners ---------------------------------------------------------------------------------------------

WINDOW = 1 << 16
"""Minimum number of entries that a slot gets space for at once."""


@dataclass(frozen=True, slots=True)
class _Ranked:
    nodes: Integers
    ranks: Integers
    core: int


def label(
    contracted: ContractedGraph, inherited: Integers | None, *, most_entries: int, longest: int, threads: int,
    check: Callable[[], None],
) -> LabelPool | None:  # fmt: skip
    """Order the nodes of a contracted graph by importance and label them; return None if the core does not fit.

    Core nodes are ordered by inherited ranks, if given. The most important nodes are labelled, as many as
    ``most_entries`` allows.

    Raises
    ------
    InvalidPlanner
        A path between two corners is longer than ``longest``.
    """
    ranked = _rank(contracted, inherited, threads=threads, check=check)
    edges = edges_of(contracted, ranked.nodes, ranked.ranks)
    pool = LabelPool(ranked.ranks)
    if not CoreLabels(pool, edges, ranked.core, longest=longest, threads=threads).label(most_entries, check):
        return None
    levels = contracted.levels[ranked.nodes]
    _label_rest(
        pool, edges, levels, ranked.core, most_entries=most_entries, longest=longest, threads=threads, check=check
    )
    return pool


def _rank(
    contracted: ContractedGraph, inherited: Integers | None, *, threads: int, check: Callable[[], None]
) -> _Ranked:
    ranks = np.full(len(contracted.head), -1, np.int32)
    # By level: labels depend only on labels of higher levels.
    last = contracted.order[::-1]
    last = last[np.argsort(-contracted.levels[last], kind="stable")]
    ranks[last] = np.arange(len(ranks) - len(last), len(ranks))
    core = np.flatnonzero(ranks < 0).astype(np.int32)
    ranks[core] = np.arange(len(core))
    if inherited is None:
        order = order_core(edges_of(contracted, core, ranks), threads=threads, check=check)
    else:
        # As unsigned numbers, missing ranks (−1) come last.
        order = np.argsort(inherited[core].view(np.uint32), kind="stable").astype(np.int32)
    nodes = np.concatenate((core[order], last))
    ranks[nodes] = np.arange(len(nodes))
    return _Ranked(nodes, ranks, len(core))


def _label_rest(
    pool: LabelPool, edges: RankedEdges, levels: Integers, core: int, *, most_entries: int, longest: int, threads: int,
    check: Callable[[], None],
) -> None:  # fmt: skip
    nodes, slots = len(pool.ranks), max(1, threads)
    reach, by_edge = np.full((2, slots, nodes), FAR, np.int32)
    marks = np.zeros((slots, (nodes + 63) // 64), np.int64)
    others = np.arange(core, nodes, dtype=np.int32)
    windows = np.zeros((slots, 4), np.int64)
    for whole in np.split(others, np.flatnonzero(np.diff(levels[others])) + 1):
        level = whole[: _most_labels(pool, most_entries)]
        if not len(level):
            break
        usable = threads if len(level) >= FEW else 1
        windows[:, 0] = np.arange(slots)
        while (windows[:, 0] < len(level)).any():
            check()
            before = windows[:, 0].copy()
            merge(
                level, edges.starts, edges.to, edges.lengths, edges.ids,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends,
                reach, by_edge, marks, windows, longest, WORK_A_SLICE, usable,
            )  # fmt: skip
            if windows[:, 3].any():
                raise too_long(longest)
            for slot in np.flatnonzero((windows[:, 0] == before) & (before < len(level))):
                _open_window(pool, windows[slot], _most_entries(pool, edges, int(level[windows[slot, 0]])), check)
        pool.labelled += len(level)


def _most_labels(pool: LabelPool, most_entries: int) -> int:
    """Return the number of labels that still fit, assuming the mean size of those before."""
    labelled = pool.labelled
    if labelled == len(pool.ranks):
        return 0
    used = int((pool.ends[:labelled] - pool.begins[:labelled]).sum())
    mean = max(1, used // max(1, labelled))
    return max(0, min(layout.MOST_HUBS - labelled, (most_entries - used) // mean))


def _most_entries(pool: LabelPool, edges: RankedEdges, node: int) -> int:
    above = edges.to[edges.starts[node] : edges.starts[node + 1]]
    return int((pool.ends[above] - pool.begins[above]).sum()) + 1


def _open_window(pool: LabelPool, window: Words, least: int, check: Callable[[], None]) -> None:
    size = max(WINDOW, 2 * least, pool.used // 8)
    if pool.used + size > pool.capacity:
        pool.extend(max(size, pool.capacity // 2), check)
    window[1:3] = pool.used, pool.used + size
    pool.used += size
