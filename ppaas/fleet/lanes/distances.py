"""Distances between moves along lanes: robots on two of them must not touch."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ppaas.errors import InvalidInput
from ppaas.fleet.lanes.placing import Placed
from ppaas.polygons import Points, distances_between, distances_to_edges

ROUNDING = 1e-6
"""Distance by which moves may be too near, since numbers are rounded [m]."""


def check_apart(placed: Placed, spacing: float) -> None:
    """Check that all that does not share a cell is at least a spacing apart: moves, and cells beside moves.

    Raises
    ------
    InvalidInput
        Two lanes are too near to each other; the text names them, and where.
    """
    moves = np.array(sorted({(min(move), max(move)) for move in placed.names}), np.int64)
    begins, ends = placed.centres[moves[:, 0]], placed.centres[moves[:, 1]]
    longest = float(np.hypot(*(ends - begins).T).max())
    pairs = cKDTree((begins + ends) / 2.0).query_pairs(longest + spacing, output_type="ndarray")
    one, other = pairs[:, 0], pairs[:, 1]
    apart = distances_between(begins[one], ends[one], begins[other], ends[other])
    shared = (moves[one][:, :, np.newaxis] == moves[other][:, np.newaxis]).any(axis=(1, 2))
    apart[shared] = _apart_beside(moves[one[shared]], moves[other[shared]], placed.centres)
    for worst in np.argsort(apart)[:1]:
        if apart[worst] < spacing - ROUNDING:
            names = sorted({_name(placed, moves[one[worst]]), _name(placed, moves[other[worst]])})
            x, y = (begins[one[worst]] + ends[one[worst]] + begins[other[worst]] + ends[other[worst]]) / 4.0
            what = f"lanes {names[0]!r} and {names[1]!r}" if len(names) > 1 else f"parts of lane {names[0]!r}"
            raise InvalidInput(
                f"{what} are {apart[worst]:.2f} m apart near {x:.2f}, {y:.2f}, and "
                f"robots of this size need {spacing:.2f} m: draw them farther apart, or join them"
            )


def _apart_beside(moves: NDArray[np.int64], others: NDArray[np.int64], centres: Points) -> NDArray[np.float64]:
    """Return how near the far end of each of two moves that share a cell is to the other move, row by row [m]."""
    swapped = (moves[:, 0, np.newaxis] == others).any(axis=1)
    own = np.where(swapped, moves[:, 1], moves[:, 0])
    shared = np.where(swapped, moves[:, 0], moves[:, 1])
    far = np.where(others[:, 0] == shared, others[:, 1], others[:, 0])
    a, b, c = centres[own], centres[shared], centres[far]
    return np.asarray(np.minimum(distances_to_edges(a, b, c), distances_to_edges(b, c, a)))


def _name(placed: Placed, move: NDArray[np.int64]) -> str:
    one, other = move.tolist()
    return placed.names.get((one, other)) or placed.names[other, one]
