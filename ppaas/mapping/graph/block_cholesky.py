"""Sparse Cholesky factorisation of symmetric positive definite matrices with blocks of 3 × 3, by a plan of fronts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.kernels import fronts
from ppaas.mapping.graph.kernels.elimination_tree import elimination_tree, front_rows, postorder, supernodes
from ppaas.mapping.graph.kernels.fronts import stack_size
from ppaas.mapping.graph.kernels.minimum_degree import minimum_degree

# -- elimination plan: a fill-reducing order and the dense fronts ------------------------------------------------------

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


# -- the factorisation -------------------------------------------------------------------------------------------------

Floats = NDArray[np.float64]


class BlockCholesky:
    """Factor of matrices of one pattern; the elimination is planned once.

    Parameters
    ----------
    count : int
        Number of block rows.
    first, second : (m,) array
        Block rows of the blocks outside the diagonal: ``first < second``, each pair once.
    """

    def __init__(self, count: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> None:
        self._plan = plan_elimination(count, first, second)
        self._panels = np.empty(self._plan.size)
        self._stack = np.empty(self._plan.stack)

    @property
    def size(self) -> int:
        """Numbers stored in the factor."""
        return self._plan.size

    def factorise(self, diagonal: Floats, off_diagonal: Floats, damping: Floats) -> bool:
        """Factorise a matrix; return False if it is not positive definite.

        Parameters
        ----------
        diagonal : (n, 3, 3) array
            Blocks on the diagonal.
        off_diagonal : (m, 3, 3) array
            Block of each pair, in row ``second`` and column ``first``.
        damping : (n, 3) array
            Numbers to add to the diagonal.
        """
        p = self._plan
        structure = (p.starts, p.row_starts, p.rows, p.children, p.panel_starts)
        entries = (p.entry_starts, p.entry_rows, p.entry_slots)
        by_column = np.empty_like(diagonal)
        by_column[p.labels] = diagonal
        damped = np.empty_like(damping)
        damped[p.labels] = damping
        failed = fronts.factorise(*structure, *entries, by_column, off_diagonal, damped, self._stack, self._panels)
        return bool(failed < 0)

    def solve(self, right: Floats) -> Floats:
        """Return x with H x = b for right-hand sides b of shape (n, 3) or (n, 3, k), after `factorise`."""
        p = self._plan
        values = np.empty((len(p.labels), 3, right[0, 0].size if len(right) else 1))
        values[p.labels] = right.reshape(values.shape)
        fronts.solve(p.starts, p.row_starts, p.rows, p.panel_starts, self._panels, values)
        solved: Floats = values[p.labels].reshape(right.shape)
        return solved
