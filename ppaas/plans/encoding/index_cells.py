"""Positions and cells of the spatial index of stored plans, and the scope of a map version."""

import hashlib
import itertools
import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

CELL_EDGE = 2.0
"""Edge of the cells of the index of entries by the positions that they pass [m]."""

_FARTHEST = 2**40
"""Largest cell coordinate; positions farther out count as there."""

Position = tuple[float, float]
"""x, y [m]."""


@lru_cache(256)
def scope_of(map_id: str, version: str) -> bytes:
    """Return 16 bytes for a map version. Plans and shared segments never reach beyond one scope."""
    return hashlib.blake2b(f"{map_id}\0{version}".encode(), digest_size=16).digest()


def cells_near(place: Position, tolerance: float) -> list[tuple[int, int]]:
    """Return the cells with the edge ``CELL_EDGE`` that reach within a tolerance of a position [m]."""
    rows, columns = (
        [math.floor(_limited((value + side * tolerance) / CELL_EDGE)) for side in (-1, 1)] for value in place
    )
    return list(itertools.product(range(rows[0], rows[1] + 1), range(columns[0], columns[1] + 1)))


def cells_touched(points: NDArray[np.float64]) -> set[tuple[int, int]]:
    """Return the cells with the edge ``CELL_EDGE`` that contain any of (n, 2) points [m]."""
    cells = np.floor(np.clip(points / CELL_EDGE, -_FARTHEST, _FARTHEST)).astype(np.int64)
    return set(zip(*cells.T.tolist(), strict=True))


def _limited(value: float) -> float:
    return min(max(value, -_FARTHEST), _FARTHEST)
