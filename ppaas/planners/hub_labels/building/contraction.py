"""Contraction of the visibility graph of corners."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE, ContractedGraph, CornerGraph
from ppaas.planners.hub_labels.building.kernels.bucket_queue import ENTRY
from ppaas.planners.hub_labels.building.kernels.contraction import (
    CONTRACTED,
    EDGES,
    FIRST_CAPACITY,
    NEXT,
    build_rows,
    contract,
    list_edges,
)
from ppaas.planners.hub_labels.building.kernels.contraction_order import confirm_nodes, select_nodes
from ppaas.planners.hub_labels.building.kernels.shortcuts import EDGE_VISITS, TARGETS_A_VECTOR, Targets, find_shortcuts
from ppaas.planners.hub_labels.building.kernels.shortcuts import NEXT as NEXT_OF_SLOT
from ppaas.planners.hub_labels.building.kernels.shortcuts import USED as USED_OF_SLOT
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.scan import Integers

NODES_A_SLICE = 1 << 16
"""Nodes examined between two calls of ``check``."""

SETTLED, ALL = 12, 1 << 40
"""Nodes that a witness search settles before a shortcut is added: in general, and for a dense map (all). Longer
searches leave a smaller core. But the core is ordered better than contracted nodes, so they pay off only if the core
would be too large. On dense maps, examining unnecessary shortcuts later would take longer than finding the
witnesses."""

SETTLED_FOR_A_COST = 2
"""The same when the cost of a node is updated, on average four times before it is contracted, once nodes may have more
neighbours than at first. A full search follows before the node is contracted."""

MOST_NEIGHBOURS = 16
"""Largest number of neighbours of a contracted node, unless the core must be smaller."""

QUEUE_PUTS = 1 << 14
"""Capacity of the queue of a witness search; further nodes are not examined."""

BUCKETS = 1 << 12
"""Buckets of that queue; they cover an edge of 2,900 cells."""

PAIRS = 1 << 16
"""Initial capacity of a slot for pairs of neighbours."""

FEW = 64
"""Nodes of a round below which waking threads takes longer than the work."""

ANY_COST = np.empty(0, np.int32)
"""No given costs: the contraction computes them."""

ANY_NUMBER = 1 << 60
"""No limit."""


class Contraction:
    """A graph under contraction.

    Parameters
    ----------
    graph : CornerGraph
        The graph.
    costs : int32 array
        Given costs of the nodes, which are contracted from low to high cost; empty to compute them.
    thorough : bool
        Whether witness searches are exhaustive.
    most_edges, most_edge_visits : int
        Limits on edges, and on edge visits of witness searches; beyond them the contraction is given up.
    threads : int
        Maximum number of threads for kernels.
    """

    def __init__(
        self, graph: CornerGraph, costs: Integers = ANY_COST, *,
        thorough: bool = False, most_edges: int = ANY_NUMBER, most_edge_visits: int = ANY_NUMBER, threads: int = 1,
    ) -> None:  # fmt: skip
        nodes, edges, self._slots = len(graph.starts) - 1, len(graph.to), max(1, threads)
        self._costs_given, self._most_edges, self._most_looks = len(costs) > 0, most_edges, most_edge_visits
        self._settle = ALL if thorough else SETTLED
        self._costs = costs.copy() if self._costs_given else np.zeros(nodes, np.int32)
        self._begins = np.empty(nodes, np.int64)
        self._degrees, self._capacities, self._levels, self._order = np.zeros((4, nodes), np.int32)
        self._rows = np.empty((edges + FIRST_CAPACITY * nodes, 3), np.int32)
        self._edges = np.empty((edges, 5), np.int32)
        self._contracted_nodes, self._in_round = np.zeros((2, nodes), np.bool_)
        self._state = np.zeros(4, np.int64)
        build_rows(
            graph.positions, graph.starts, graph.to, graph.lengths,
            self._begins, self._degrees, self._capacities, self._rows, self._edges, self._state,
        )  # fmt: skip
        self._positions = graph.positions
        self._reached, self._limits = np.zeros((2, self._slots, nodes), np.int64)
        self._buckets = np.empty((self._slots, BUCKETS), np.int32)
        self._entries = np.empty((self._slots, QUEUE_PUTS, ENTRY), np.int64)
        self._pairs = np.empty((self._slots, PAIRS), np.int32)
        self._slot_states = np.zeros((self._slots, 4), np.int64)
        self._most = MOST_NEIGHBOURS

    @property
    def core(self) -> int:
        """Number of nodes that are not contracted."""
        return len(self._order) - int(self._state[CONTRACTED])

    @property
    def is_given_up(self) -> bool:
        """Whether a limit on edges or edge visits was exceeded."""
        looks = int(self._slot_states[:, EDGE_VISITS].sum())
        return int(self._state[EDGES]) > 2 * self._most_edges or looks > self._most_looks

    def run(self, core: int | None = None, *, check: Callable[[], None]) -> ContractedGraph:
        """Contract nodes with few neighbours, and return the contracted graph.

        If ``core`` is given, the limit on neighbours is raised until at most that many nodes are left. If the
        contraction is given up, the result is not usable.
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
        targets = np.zeros((self._slots, 4, -(-self._most // TARGETS_A_VECTOR) * TARGETS_A_VECTOR), np.int32)
        batch = np.empty(len(self._begins), np.int32)
        while self.core > core and not self.is_given_up and (count := self._select(batch, check)):
            thorough_at_once = self._costs_given or self._most == MOST_NEIGHBOURS
            settle = self._settle * self._most // MOST_NEIGHBOURS
            counts = self._find_shortcuts(
                batch[:count], targets, settle if thorough_at_once else SETTLED_FOR_A_COST, check
            )
            if not self._costs_given:
                count = self._confirm(batch[:count], counts, check)
            if not thorough_at_once:
                counts = self._find_shortcuts(batch[:count], targets, settle, check)
            self._contract_round(batch[:count], counts, core, check)

    def _select(self, batch: Integers, check: Callable[[], None]) -> int:
        count = 0
        for first in range(0, len(batch), NODES_A_SLICE):
            check()
            last = min(first + NODES_A_SLICE, len(batch))
            count = select_nodes(
                first, last, self._begins, self._degrees, self._rows, self._costs, self._contracted_nodes,
                self._most, batch, count, self._in_round,
            )  # fmt: skip
        return count

    def _confirm(self, batch: Integers, counts: Rows, check: Callable[[], None]) -> int:
        kept = 0
        for first in range(0, len(batch), NODES_A_SLICE):
            check()
            last = min(first + NODES_A_SLICE, len(batch))
            kept = confirm_nodes(
                batch, counts, first, last, kept, self._begins, self._degrees, self._rows, self._levels,
                self._costs, self._most, self._in_round,
            )  # fmt: skip
        return kept

    def _find_shortcuts(self, batch: Integers, targets: Targets, settle: int, check: Callable[[], None]) -> Rows:
        counts, states = np.empty((len(batch), 3), np.int32), self._slot_states
        states[:, NEXT_OF_SLOT], states[:, USED_OF_SLOT] = np.arange(self._slots), 0
        while (states[:, NEXT_OF_SLOT] < len(batch)).any():
            check()
            before = states[:, NEXT_OF_SLOT].copy()
            find_shortcuts(
                batch, self._begins, self._degrees, self._rows, self._in_round, self._positions, self._reached,
                self._limits, targets, self._buckets, self._entries, self._pairs, counts, states,
                settle, WORK_A_SLICE,
                self._slots if len(batch) >= FEW else 1,
            )  # fmt: skip
            if ((states[:, NEXT_OF_SLOT] == before) & (before < len(batch))).any():
                self._pairs = np.pad(self._pairs, ((0, 0), (0, self._pairs.shape[1])))
        return counts

    def _contract_round(self, batch: Integers, counts: Rows, core: int, check: Callable[[], None]) -> None:
        self._state[NEXT] = 0
        done = False
        while not done:
            check()
            before = int(self._state[NEXT])
            done = contract(
                batch, self._pairs, counts, self._begins, self._degrees, self._capacities, self._rows, self._edges,
                self._levels, self._contracted_nodes, self._in_round, self._order, self._state, core, WORK_A_SLICE,
            )  # fmt: skip
            if not done and self._state[NEXT] == before:
                self._enlarge()

    def _enlarge(self) -> None:
        self._edges = np.resize(self._edges, (len(self._edges) * 3 // 2 + PAIRS, 5))
        self._rows = np.resize(self._rows, (len(self._rows) * 3 // 2 + PAIRS, 3))
