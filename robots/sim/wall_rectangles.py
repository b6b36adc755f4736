"""Decomposition of walls into few rectangles, so large maps become collision shapes quickly."""

import numpy as np
from numpy.typing import NDArray


def merge_rectangles(occupied: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Cover the occupied cells with disjoint rectangles.

    Finds horizontal runs first; equal runs in consecutive rows are merged into one rectangle.

    Parameters
    ----------
    occupied : (height, width) bool array
        Row 0 is the lowest.

    Returns
    -------
    (n, 4) int array
        First column, first row, and the column and row after the last.
    """
    runs = _runs(occupied)
    if not len(runs):
        return np.empty((0, 4), np.int64)
    row, first, last = runs[np.lexsort((runs[:, 0], runs[:, 2], runs[:, 1]))].T
    begins = np.ones(len(row), bool)
    begins[1:] = (np.diff(first) != 0) | (np.diff(last) != 0) | (np.diff(row) != 1)
    start = np.flatnonzero(begins)
    end = np.append(start[1:], len(row)) - 1
    return np.stack((first[start], row[start], last[start], row[end] + 1), axis=1)


def _runs(occupied: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return (n, 3) rows of: row, first column, column after the last."""
    edges = np.diff(np.pad(occupied.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    row, first = np.nonzero(edges == 1)
    _, last = np.nonzero(edges == -1)
    return np.stack((row, first, last), axis=1).astype(np.int64)
