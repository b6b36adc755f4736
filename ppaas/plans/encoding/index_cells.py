"""Places on a map as stores know them: pairs of coordinates, squares, and whose map it is."""

import hashlib
import itertools
import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

CELL_EDGE = 2.0
"""Edge of the squares by which it is found which entries pass a place [m]."""

_FARTHEST = 2**40

Position = tuple[float, float]


@lru_cache(256)
def scope_of(map_id: str, version: str) -> bytes:
    """Return 16 bytes for a version of a map: plans and what they share never reach beyond one."""
    return hashlib.blake2b(f"{map_id}\0{version}".encode(), digest_size=16).digest()


def cells_near(place: Position, tolerance: float) -> list[tuple[int, int]]:
    """Return the squares of ``CELL_EDGE`` that reach within a tolerance of a place [m]."""
    rows, columns = (
        [math.floor(_limited((value + side * tolerance) / CELL_EDGE)) for side in (-1, 1)] for value in place
    )
    return list(itertools.product(range(rows[0], rows[1] + 1), range(columns[0], columns[1] + 1)))


def cells_touched(points: NDArray[np.float64]) -> set[tuple[int, int]]:
    """Return the squares of ``CELL_EDGE`` in which some of (n, 2) points lie [m]."""
    squares = np.floor(np.clip(points / CELL_EDGE, -_FARTHEST, _FARTHEST)).astype(np.int64)
    return set(zip(*squares.T.tolist(), strict=True))


def _limited(value: float) -> float:
    return min(max(value, -_FARTHEST), _FARTHEST)
