"""Occupied cells of a map as bodies."""

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.maps.grid import GridInfo


def wall_of(occupied: NDArray[np.bool_], info: GridInfo) -> tuple[pymunk.Body, list[pymunk.Shape]]:
    """Return a static body of the occupied cells of a map, and its shapes; nothing of it is in a space yet."""
    body = pymunk.Body(body_type=pymunk.Body.STATIC)
    body.position = info.origin.x, info.origin.y
    body.angle = info.origin.theta
    corners = (merge_rectangles(occupied) * info.resolution).tolist()
    shapes: list[pymunk.Shape] = [pymunk.Poly.create_box_bb(body, pymunk.BB(*box)) for box in corners]
    for shape in shapes:
        shape.friction = 0.4
    return body, shapes


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
