"""Gated global assignment: which observation is which known person."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]


Solver = Callable[[Array], tuple[Rows, Rows]]


@cache
def solver() -> Solver:
    """Return scipy's solver of the linear assignment problem (Crouse, IEEE Trans. Aerospace 52, 2016).

    It is imported by the first call, which takes some 0.3 s and memory that other nodes do not need. A caller with
    a cycle to keep calls it beforehand in another thread; a call meanwhile waits for the import.
    """
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - see above

    solve: Solver = linear_sum_assignment
    return solve


def assign(costs: Array, limit: float, solve: Solver | None = None) -> tuple[Rows, Rows]:
    """Assign rows to columns so that the sum of their costs is least; a pair without an assignment costs the limit.

    Parameters
    ----------
    costs : (n, m) array
        Cost of each pair; infinite where a pair is impossible.
    limit : float
        Cost from which a pair is not assigned: the gate.
    solve : callable, optional
        Solves what is ambiguous; by default scipy's solver.

    Returns
    -------
    rows, columns : (k,) int arrays
        The assigned pairs, by rows.
    """
    allowed = costs < limit
    if not allowed.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    rows, columns = np.flatnonzero(allowed.any(axis=1)), np.flatnonzero(allowed.any(axis=0))
    if (allowed.sum(axis=1) <= 1).all() and (allowed.sum(axis=0) <= 1).all():
        return rows, np.argmax(allowed[rows], axis=1)

    part = np.minimum(costs[np.ix_(rows, columns)], limit)
    left, right = (solve or solver())(part)
    kept = part[left, right] < limit
    return rows[left[kept]], columns[right[kept]]
