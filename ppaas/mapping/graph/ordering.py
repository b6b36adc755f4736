"""Elimination plan of a sparse symmetric block matrix: a fill-reducing order and the dense fronts of its factor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.kernels.elimination_tree import elimination_tree, front_rows, postorder, supernodes
from ppaas.mapping.graph.kernels.fronts import stack_size
from ppaas.mapping.graph.kernels.minimum_degree import minimum_degree

SMALL_FRONT = 4
"""Fronts of at most so many block columns are always joined with their parents'."""

ZERO_SHARE = 0.25
"""Largest share of zeros stored in a joined front."""

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Elimination:
    """Order of elimination, and structure of the factor.

    Attributes
    ----------
    labels : (n,) array
        Block column of each node.
    starts : (s + 1,) array
        First block column of each supernode.
    row_starts, rows : (s + 1,), (r,) array
        Start of each front's block rows, and the block rows.
    children : (s,) array
        Number of children of each front.
    panel_starts : (s + 1,) array
        Start of each supernode's numbers in the factor.
    entry_starts, entry_rows, entry_slots : (n + 1,), (m,), (m,) array
        Pairs by the block column that is eliminated first: start, block row of the other, and index of the pair; the
        complement of the index where the second node of the pair is eliminated first.
    stack : int
        Numbers that the update matrices need at once.
    """

    labels: Ints
    starts: Ints
    row_starts: Ints
    rows: Ints
    children: Ints
    panel_starts: Ints
    entry_starts: Ints
    entry_rows: Ints
    entry_slots: Ints
    stack: int

    @property
    def size(self) -> int:
        """Numbers in the factor."""
        return int(self.panel_starts[-1])


def plan_elimination(count: int, first: Ints, second: Ints) -> Elimination:
    """Return the elimination plan of a matrix.

    Parameters
    ----------
    count : int
        Number of nodes, which are the block rows of the matrix.
    first, second : (m,) array
        Nodes of its blocks outside the diagonal: ``first < second``, each pair once.
    """
    order, member_starts, members = minimum_degree(*_neighbours(count, first, second))
    parents, counts = elimination_tree(order, member_starts, members), np.diff(member_starts) + 1
    steps = postorder(parents, counts)
    columns = np.empty(count, np.int64)
    columns[steps] = np.arange(count)
    labels = np.empty(count, np.int64)
    labels[order] = columns
    column_parents = np.where(parents[steps] >= 0, columns[parents[steps]], -1)
    starts, heights = supernodes(column_parents, counts[steps], SMALL_FRONT, ZERO_SHARE)
    row_starts, rows, children = front_rows(starts, heights, steps, labels, member_starts, members)
    panel_starts = np.concatenate(([0], np.cumsum(9 * np.diff(starts) * heights)))
    entries = _entries(count, labels[first], labels[second])
    stack = stack_size(starts, row_starts, children)
    return Elimination(labels, starts, row_starts, rows, children, panel_starts, *entries, stack)


def _neighbours(count: int, first: Ints, second: Ints) -> tuple[Ints, Ints]:
    """Return the neighbours of all nodes, and the start of each node's."""
    ends, others = np.concatenate((first, second)), np.concatenate((second, first))
    starts = np.concatenate(([0], np.cumsum(np.bincount(ends, minlength=count))))
    return starts, others[np.argsort(ends, kind="stable")]


def _entries(count: int, first: Ints, second: Ints) -> tuple[Ints, Ints, Ints]:
    """Return the pairs by the smaller of their columns: starts, larger columns, and slots."""
    slots = np.where(first < second, np.arange(first.size), ~np.arange(first.size))
    columns = np.minimum(first, second)
    order = np.argsort(columns, kind="stable")
    starts = np.concatenate(([0], np.cumsum(np.bincount(columns, minlength=count))))
    return starts, np.maximum(first, second)[order], slots[order]
