"""Polygons in the plane: which points are inside, and how far points and edges are from edges."""

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


def distances_to_edges(begins: Points, ends: Points, places: Points) -> Points:
    """Return the distances of places from edges [m].

    Parameters
    ----------
    begins, ends, places : (..., 2) array
        Ends of the edges, and places [m]; the leading axes are broadcast.
    """
    along, offset = ends - begins, places - begins
    squared = np.maximum(along[..., 0] ** 2 + along[..., 1] ** 2, 1e-12)
    part = np.clip((offset[..., 0] * along[..., 0] + offset[..., 1] * along[..., 1]) / squared, 0.0, 1.0)
    distances: Points = np.hypot(offset[..., 0] - part * along[..., 0], offset[..., 1] - part * along[..., 1])
    return distances


def distances_between(begins: Points, ends: Points, others: Points, other_ends: Points) -> Points:
    """Return the distances of edges from other edges [m]; 0 where they cross.

    Parameters
    ----------
    begins, ends, others, other_ends : (..., 2) array
        Ends of both [m]; the leading axes are broadcast.
    """
    apart = np.minimum.reduce([
        distances_to_edges(begins, ends, others),
        distances_to_edges(begins, ends, other_ends),
        distances_to_edges(others, other_ends, begins),
        distances_to_edges(others, other_ends, ends),
    ])  # fmt: skip
    crosses = _sides(begins, ends, others) * _sides(begins, ends, other_ends) < 0.0
    crosses &= _sides(others, other_ends, begins) * _sides(others, other_ends, ends) < 0.0
    return np.where(crosses, 0.0, apart)


def _sides(begins: Points, ends: Points, places: Points) -> Points:
    """Return 1 for places to the left of edges, −1 to the right of them, 0 on their lines."""
    along, aside = ends - begins, places - begins
    return np.asarray(np.sign(along[..., 0] * aside[..., 1] - along[..., 1] * aside[..., 0]))


def within_polygon(corners: Points, points: Points) -> NDArray[np.bool_]:
    """Return which of (n, 2) points are in the polygon of (m, 2) corners, by the number of edges to their right."""
    x, y = points[:, 0, np.newaxis], points[:, 1, np.newaxis]
    (ax, ay), (bx, by) = corners.T, np.roll(corners, -1, axis=0).T
    crosses = (ay > y) != (by > y)
    rise = np.where(crosses, by - ay, 1.0)  # the rise of another edge may be so small that the quotient overflows
    inside: NDArray[np.bool_] = (crosses & (x < ax + (y - ay) * (bx - ax) / rise)).sum(axis=1) % 2 == 1
    return inside
