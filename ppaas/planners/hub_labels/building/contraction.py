"""The contraction of the graph of corners."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE, ContractedGraph, CornerGraph
from ppaas.planners.hub_labels.building.kernels.bucket_queue import ENTRY
from ppaas.planners.hub_labels.building.kernels.contraction import (
    CONTRACTED,
    EDGES,
    FIRST_ROOM,
    NEXT,
    contract,
    lay_rows,
    list_edges,
)
from ppaas.planners.hub_labels.building.kernels.contraction_order import admit, choose
from ppaas.planners.hub_labels.building.kernels.shortcuts import AT_A_TIME, SCANS, Targets, find_shortcuts
from ppaas.planners.hub_labels.building.kernels.shortcuts import NEXT as NEXT_OF_SLOT
from ppaas.planners.hub_labels.building.kernels.shortcuts import USED as USED_OF_SLOT
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.scan import Integers

NODES_A_SLICE = 1 << 16

SETTLED, ALL = 12, 1 << 40
"""Nodes that a search for another way settles before a shortcut is made. To look further leaves a smaller core: that is
ordered better than what is contracted, so it is worth it only where the core would be too large. There all are settled
over which a way may lead: shortcuts that are not needed would take longer to look at than they take to be found so."""

SETTLED_FOR_A_PRICE = 2
"""The same to tell a price again, four times in the mean until a node goes, where nodes may have more neighbours than
at first: whoever goes is looked at thoroughly after that."""

MOST_NEIGHBOURS = 16
"""Neighbours that a node may have to be contracted, unless the core has to be smaller."""

PUTS = 1 << 14
"""How often a node may be put into the queue of such a search; further ones are not looked at."""

BUCKETS = 1 << 12
"""Buckets of that queue: as many as an edge of 2,900 cells is long."""

PAIRS = 1 << 16
"""Pairs of neighbours that a slot has room for, at least."""

FEW = 64
"""Nodes of a round, below which it takes longer to wake threads than to look at them."""

ANY_COST = np.empty(0, np.int32)
ANY_NUMBER = 1 << 60


class Contraction:
    """A graph that is contracted further and further.

    Parameters
    ----------
    graph : CornerGraph
    prices : int32 array
        The nodes are contracted in the order of these, where they are given.
    thorough : bool
        Whether to look for all other ways before a shortcut is made.
    most_edges, most_scans : int
        It ends before its time once there are more edges, or it has looked at more to find shortcuts.
    threads : int
        Most threads that kernels may use.
    """

    def __init__(
        self, graph: CornerGraph, prices: Integers = ANY_COST, *,
        thorough: bool = False, most_edges: int = ANY_NUMBER, most_scans: int = ANY_NUMBER, threads: int = 1,
    ) -> None:  # fmt: skip
        nodes, edges, self._slots = len(graph.starts) - 1, len(graph.to), max(1, threads)
        self._told, self._most_edges, self._most_looks = len(prices) > 0, most_edges, most_scans
        self._settle = ALL if thorough else SETTLED
        self._prices = prices.copy() if self._told else np.zeros(nodes, np.int32)
        self._begins = np.empty(nodes, np.int64)
        self._degrees, self._rooms, self._levels, self._order = np.zeros((4, nodes), np.int32)
        self._rows = np.empty((edges + FIRST_ROOM * nodes, 3), np.int32)
        self._edges = np.empty((edges, 5), np.int32)
        self._gone, self._held = np.zeros((2, nodes), np.bool_)
        self._state = np.zeros(4, np.int64)
        lay_rows(
            graph.places, graph.starts, graph.to, graph.lengths,
            self._begins, self._degrees, self._rooms, self._rows, self._edges, self._state,
        )  # fmt: skip
        self._places = graph.places
        self._reached, self._limits = np.zeros((2, self._slots, nodes), np.int64)
        self._buckets = np.empty((self._slots, BUCKETS), np.int32)
        self._entries = np.empty((self._slots, PUTS, ENTRY), np.int64)
        self._pairs = np.empty((self._slots, PAIRS), np.int32)
        self._slot_states = np.zeros((self._slots, 4), np.int64)
        self._most = MOST_NEIGHBOURS

    @property
    def core(self) -> int:
        """Return how many nodes are not contracted."""
        return len(self._order) - int(self._state[CONTRACTED])

    @property
    def is_given_up(self) -> bool:
        """Tell whether there are more edges than there may be, or it took more than it may."""
        looks = int(self._slot_states[:, SCANS].sum())
        return int(self._state[EDGES]) > 2 * self._most_edges or looks > self._most_looks

    def run(self, core: int | None = None, *, check: Callable[[], None]) -> ContractedGraph:
        """Contract nodes with few neighbours, and return what there is then.

        If ``core`` is given, nodes with more and more neighbours are contracted until no more than so many are left.
        Where it is given up before, what it returns is of no use.
        """
        self._contract(core or 0, check)
        while core is not None and self.core > core and not self.is_given_up:
            self._most *= 2
            self._contract(core, check)
        used = self._state[EDGES]
        head, after = np.empty(len(self._begins), np.int32), np.empty(used, np.int32)
        list_edges(self._begins, self._degrees, self._rows, head, after)
        order = self._order[: self._state[CONTRACTED]]
        return ContractedGraph(head, after, self._edges[:used], self._levels, order)

    def _contract(self, core: int, check: Callable[[], None]) -> None:
        targets = np.zeros((self._slots, 4, -(-self._most // AT_A_TIME) * AT_A_TIME), np.int32)
        batch = np.empty(len(self._begins), np.int32)
        while self.core > core and not self.is_given_up and (count := self._choose(batch, check)):
            at_once = self._told or self._most == MOST_NEIGHBOURS
            settle = self._settle * self._most // MOST_NEIGHBOURS
            counts = self._find_shortcuts(batch[:count], targets, settle if at_once else SETTLED_FOR_A_PRICE, check)
            if not self._told:
                count = self._admit(batch[:count], counts, check)
            if not at_once:
                counts = self._find_shortcuts(batch[:count], targets, settle, check)
            self._take_out(batch[:count], counts, core, check)

    def _choose(self, batch: Integers, check: Callable[[], None]) -> int:
        count = 0
        for first in range(0, len(batch), NODES_A_SLICE):
            check()
            last = min(first + NODES_A_SLICE, len(batch))
            count = choose(
                first, last, self._begins, self._degrees, self._rows, self._prices, self._gone,
                self._most, batch, count, self._held,
            )  # fmt: skip
        return count

    def _admit(self, batch: Integers, counts: Rows, check: Callable[[], None]) -> int:
        kept = 0
        for first in range(0, len(batch), NODES_A_SLICE):
            check()
            last = min(first + NODES_A_SLICE, len(batch))
            kept = admit(
                batch, counts, first, last, kept, self._begins, self._degrees, self._rows, self._levels,
                self._prices, self._most, self._held,
            )  # fmt: skip
        return kept

    def _find_shortcuts(self, batch: Integers, targets: Targets, settle: int, check: Callable[[], None]) -> Rows:
        counts, states = np.empty((len(batch), 3), np.int32), self._slot_states
        states[:, NEXT_OF_SLOT], states[:, USED_OF_SLOT] = np.arange(self._slots), 0
        while (states[:, NEXT_OF_SLOT] < len(batch)).any():
            check()
            before = states[:, NEXT_OF_SLOT].copy()
            find_shortcuts(
                batch, self._begins, self._degrees, self._rows, self._held, self._places, self._reached,
                self._limits, targets, self._buckets, self._entries, self._pairs, counts, states,
                settle, WORK_A_SLICE,
                self._slots if len(batch) >= FEW else 1,
            )  # fmt: skip
            if ((states[:, NEXT_OF_SLOT] == before) & (before < len(batch))).any():
                self._pairs = np.pad(self._pairs, ((0, 0), (0, self._pairs.shape[1])))
        return counts

    def _take_out(self, batch: Integers, counts: Rows, core: int, check: Callable[[], None]) -> None:
        self._state[NEXT] = 0
        done = False
        while not done:
            check()
            before = int(self._state[NEXT])
            done = contract(
                batch, self._pairs, counts, self._begins, self._degrees, self._rooms, self._rows, self._edges,
                self._levels, self._gone, self._held, self._order, self._state, core, WORK_A_SLICE,
            )  # fmt: skip
            if not done and self._state[NEXT] == before:
                self._make_room()

    def _make_room(self) -> None:
        self._edges = np.resize(self._edges, (len(self._edges) * 3 // 2 + PAIRS, 5))
        self._rows = np.resize(self._rows, (len(self._rows) * 3 // 2 + PAIRS, 3))
