"""Linear assignment without scipy, for the few people around one robot.

The import of scipy takes a third of a second and memory, which a clone does not have to spare; a robot may not have
scipy at all. Source: Kuhn, "The Hungarian method for the assignment problem" (1955), by shortest augmenting paths with
potentials, O(n² m), as in Jonker and Volgenant (1987).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp]


def least_cost(costs: Array) -> tuple[Rows, Rows]:
    """Return the rows and columns of an assignment with the least sum of costs, as ``linear_sum_assignment``.

    Parameters
    ----------
    costs : (n, m) array
        Finite costs. All rows are assigned, or all columns if they are fewer.

    Returns
    -------
    rows, columns : (min(n, m),) int arrays
        Sorted by rows.
    """
    if costs.shape[0] > costs.shape[1]:
        columns, rows = least_cost(costs.T)
        order = np.argsort(rows)
        return rows[order], columns[order]
    n, m = costs.shape
    row_of = np.full(m + 1, -1, np.intp)  # column m is where each path starts
    for_rows, for_columns = np.zeros(n), np.zeros(m + 1)
    for row in range(n):
        row_of[m] = row
        _augment(costs, row_of, for_rows, for_columns)
    columns = np.flatnonzero(row_of[:m] >= 0)
    order = np.argsort(row_of[columns])
    return row_of[columns][order], columns[order]


def _augment(costs: Array, row_of: Rows, for_rows: Array, for_columns: Array) -> None:
    """Assign the row of the last entry of ``row_of`` along a shortest path, and update the potentials, in place."""
    m = costs.shape[1]
    shortest, before = np.full(m, np.inf), np.full(m, m, np.intp)
    visited = np.zeros(m + 1, bool)
    column = m
    while row_of[column] >= 0:
        visited[column] = True
        row = row_of[column]
        reduced = costs[row] - for_rows[row] - for_columns[:m]
        nearer = ~visited[:m] & (reduced < shortest)
        shortest[nearer], before[nearer] = reduced[nearer], column
        column = int(np.argmin(np.where(visited[:m], np.inf, shortest)))
        step = shortest[column]
        for_rows[row_of[visited]] += step
        for_columns[visited] -= step
        shortest[~visited[:m]] -= step
    while column != m:
        row_of[column] = row_of[before[column]]
        column = int(before[column])
