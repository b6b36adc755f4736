"""Sparse Cholesky factorisation of symmetric positive definite matrices with blocks of 3 × 3."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.kernels import fronts
from ppaas.mapping.graph.ordering import plan_elimination

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
