"""Buckets of plans by where they begin and end: those between two places are found without looking at others.

The plane is cut into squares, so a plan lies in one of a start square and a goal square. Its *spot* is one number: the
bucket, by a hash; then the length, so that in a bucket the shortest come first; then where in its squares the ends lie,
roughly, so that most of what lies too far off is passed over unread. A spot may match by chance: whoever finds one
looks at the plan itself.
"""

import hashlib
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

EDGE = 0.5
"""Edge of a square [m]: at a tolerance of a half of it, which is common, what is sought lies in 16 buckets, but for
places right on a corner."""

LARGEST_TOLERANCE = 0.5
"""Farthest that the end of a plan may be from where it is sought [m]: 81 buckets, or up to 256."""

PLACE_EDGE = 2.0
"""Edge of the squares by which it is found which entries pass a place [m]."""

_FARTHEST = 2**40
_PARTS = 16
"""Parts of the edge of a square that are told apart."""

LENGTH_BITS, END_BITS = 20, 16
_PER_METRE = 64
_MASK = (1 << 64) - 1
_BUCKET_BITS = 63 - LENGTH_BITS - END_BITS

Place = tuple[float, float]


def scope_of(map_id: str, version: str) -> bytes:
    """Return 16 bytes for a version of a map: plans and what they share never reach beyond one."""
    return hashlib.blake2b(f"{map_id}\0{version}".encode(), digest_size=16).digest()


def rough_length(length: float) -> int:
    """Return a length [m] in 64ths of a metre; the longest are all the same."""
    return min(int(min(length, 1e9) * _PER_METRE), (1 << LENGTH_BITS) - 1)


def spot_of(scope: bytes, first: Place, last: Place, length: float) -> int:
    """Return the spot of a plan.

    Parameters
    ----------
    scope : bytes
        Of its version of a map.
    first, last : tuple of float
        x, y of its ends [m].
    length : float
        [m]

    Returns
    -------
    int
        From 0 to 2⁶³ − 1.
    """
    squares, ends = [], 0
    for value in (*first, *last):
        square, part = divmod(math.floor(_limited(value / EDGE) * _PARTS), _PARTS)
        squares.append(square)
        ends = ends << 4 | part
    return (_bucket(scope, squares) << LENGTH_BITS | rough_length(length)) << END_BITS | ends


@dataclass(frozen=True, slots=True)
class Spots:
    """Spots of one bucket among which a plan may be: from ``first`` to ``last``, and of these where the ends fit.

    ``least`` and ``most`` are the parts in which x and y of start and goal may lie.
    """

    first: int
    last: int
    least: tuple[int, int, int, int]
    most: tuple[int, int, int, int]

    def holds(self, spot: int) -> bool:
        """Tell whether a spot of this bucket may be that of a plan sought."""
        return all(
            low <= spot >> shift & 15 <= high
            for low, high, shift in zip(self.least, self.most, (12, 8, 4, 0), strict=True)
        )


def length_in(spot: int) -> int:
    """Return the rough length of the plan at a spot."""
    return spot >> END_BITS & (1 << LENGTH_BITS) - 1


def bucket_in(spot: int) -> int:
    """Return the bucket of a spot."""
    return spot >> LENGTH_BITS + END_BITS


def spots_near(scope: bytes, start: Place, goal: Place, tolerance: float) -> Iterator[Spots]:
    """Yield the buckets in which plans lie whose ends are within a tolerance of two places [m]."""
    sides = [list(_parts_near(value, tolerance)) for value in (*start, *goal)]
    for chosen in itertools.product(*sides):
        squares, least, most = zip(*chosen, strict=True)
        begin = _bucket(scope, squares) << LENGTH_BITS + END_BITS
        yield Spots(begin, begin + (1 << LENGTH_BITS + END_BITS) - 1, least, most)


def place_of(scope: bytes, square: tuple[int, int]) -> int:
    """Return a number of 31 bits for a square of ``PLACE_EDGE``."""
    return _mixed(scope, square) >> 33


def squares_near(place: Place, tolerance: float) -> list[tuple[int, int]]:
    """Return the squares of ``PLACE_EDGE`` that reach within a tolerance of a place [m]."""
    rows, columns = (
        [math.floor(_limited((value + side * tolerance) / PLACE_EDGE)) for side in (-1, 1)] for value in place
    )
    return list(itertools.product(range(rows[0], rows[1] + 1), range(columns[0], columns[1] + 1)))


def squares_touched(points: NDArray[np.float64]) -> set[tuple[int, int]]:
    """Return the squares of ``PLACE_EDGE`` in which some of (n, 2) points lie [m]."""
    squares = np.floor(np.clip(points / PLACE_EDGE, -_FARTHEST, _FARTHEST)).astype(np.int64)
    return set(zip(*squares.T.tolist(), strict=True))


def _parts_near(value: float, tolerance: float) -> Iterator[tuple[int, int, int]]:
    """Yield the squares along one axis that a tolerance reaches, each with the first and last part of it."""
    margin = tolerance + 1e-9 * max(1.0, abs(value))  # what is rounded away must not hide a plan
    low, high = (math.floor(_limited((value + side * margin) / EDGE) * _PARTS) for side in (-1, 1))
    for square in range(low // _PARTS, high // _PARTS + 1):
        begin = square * _PARTS
        yield square, max(low - begin, 0), min(high - begin, _PARTS - 1)


def _limited(value: float) -> float:
    return min(max(value, -_FARTHEST), _FARTHEST)


def _bucket(scope: bytes, squares: "tuple[int, ...] | list[int]") -> int:
    return _mixed(scope, squares) >> 64 - _BUCKET_BITS


def _mixed(scope: bytes, numbers: "tuple[int, ...] | list[int]") -> int:
    """Return a hash of 64 bits, quickly: what is found by it is looked at."""
    mixed = int.from_bytes(scope[:8], "little")
    for number in numbers:
        mixed = (mixed ^ number & _MASK) * 0x9E3779B97F4A7C15 & _MASK
        mixed ^= mixed >> 29
    return mixed * 0xBF58476D1CE4E5B9 & _MASK
