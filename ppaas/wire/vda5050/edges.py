"""Distances from edges: those of routes, and those of zones."""

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
