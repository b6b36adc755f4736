"""Kernel: the numbers by which plans are found where they begin and end (``ppaas.plans.encoding.end_buckets``)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
Rows = NDArray[np.int64]

EDGE = 0.5
PART_BITS, LENGTH_BITS, PER_METRE = 6, 18, 16
PARTS, END_BITS = 1 << PART_BITS, 4 * PART_BITS

COLUMNS = 10
"""Of a bucket: its first spot and its last, and the first and last part in which x and y of start and goal may lie."""

_FARTHEST = 2.0**40
_ROUNDED = 2.0**-50
_BUCKET_BITS = 63 - LENGTH_BITS - END_BITS
_ODD, _LAST = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9)
_SHIFT = np.uint64(29)


@njit(cache=True, nogil=True, error_model="numpy")
def mixed(scope: np.uint64, numbers: Rows) -> np.uint64:
    """Return a hash of 64 bits, quickly: what is found by it is looked at."""
    word = scope
    for number in numbers:
        word = (word ^ np.uint64(number)) * _ODD
        word ^= word >> _SHIFT
    return word * _LAST


@njit(cache=True, nogil=True, error_model="numpy")
def _part(value: float) -> int:
    """Return in which part of a square a coordinate lies, counted from zero on."""
    return int(np.floor(_in_parts(value)))


@njit(cache=True, nogil=True, error_model="numpy")
def _in_parts(value: float) -> float:
    return min(max(value / EDGE, -_FARTHEST), _FARTHEST) * PARTS


@njit(cache=True, nogil=True, error_model="numpy")
def _bucket(scope: np.uint64, squares: Rows) -> int:
    return int(np.int64(mixed(scope, squares) >> np.uint64(64 - _BUCKET_BITS)))


@njit(cache=True, nogil=True, error_model="numpy")
def spots(scopes: NDArray[np.uint64], ends: Numbers, lengths: Numbers, found: Rows) -> None:
    """Write the spots of plans.

    Parameters
    ----------
    scopes : (m,) array
    ends : (m, 4) array
        x, y of their ends [m].
    lengths : (m,) array
        [m]
    found : (m,) array
        Gets them.
    """
    squares = np.empty(4, np.int64)
    for plan in range(len(ends)):
        parts = 0
        for side in range(4):
            part = _part(ends[plan, side])
            squares[side] = part // PARTS
            parts = parts << PART_BITS | part % PARTS
        length = min(int(min(lengths[plan], 1e9) * PER_METRE), (1 << LENGTH_BITS) - 1)
        found[plan] = (_bucket(scopes[plan], squares) << LENGTH_BITS | length) << END_BITS | parts


@njit(cache=True, nogil=True, error_model="numpy")
def buckets_near(scope: np.uint64, places: Numbers, tolerance: float) -> Rows:
    """Return (k, ``COLUMNS``): the buckets in which plans lie whose ends are within a tolerance of two places.

    Parameters
    ----------
    scope : uint64
    places : (4,) array
        x, y of both [m].
    tolerance : float
        [m]
    """
    lows, highs = np.empty(4, np.int64), np.empty(4, np.int64)
    count = 1
    for side in range(4):
        # What is rounded away must not hide a plan, nor make thousands of buckets of a place far off.
        margin = tolerance + _ROUNDED * max(1.0, min(abs(places[side]), _FARTHEST))
        lows[side], highs[side] = _part(places[side] - margin), _part(places[side] + margin)
        count *= highs[side] // PARTS - lows[side] // PARTS + 1
    found, squares = np.empty((count, COLUMNS), np.int64), np.empty(4, np.int64)
    for number in range(count):
        left = number
        for side in range(3, -1, -1):
            first = lows[side] // PARTS
            left, ahead = divmod(left, highs[side] // PARTS - first + 1)
            squares[side] = first + ahead
            begin = squares[side] * PARTS
            found[number, 2 + 2 * side] = max(lows[side] - begin, 0)
            found[number, 3 + 2 * side] = min(highs[side] - begin, PARTS - 1)
        found[number, 0] = _bucket(scope, squares) << LENGTH_BITS + END_BITS
        found[number, 1] = found[number, 0] + (1 << LENGTH_BITS + END_BITS) - 1
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def may_join(spots: Rows, places: Numbers, tolerance: float) -> NDArray[np.bool_]:
    """Tell of (n,) spots in `buckets_near` whether both ends may lie within a tolerance of their places.

    Of an end it is known in which part of a square it lies; of all such parts the nearest to its place counts.
    """
    found = np.empty(len(spots), np.bool_)
    width = EDGE / PARTS
    for number in range(len(spots)):
        squared = np.zeros(2)
        for side in range(4):
            part = spots[number] >> PART_BITS * (3 - side) & PARTS - 1
            # From the middle of the part to the place, in parts, to either side.
            apart = (_in_parts(places[side]) - part - 0.5) % PARTS
            apart = max(min(apart, PARTS - apart) - 0.5, 0.0) * width
            squared[side // 2] += apart * apart
        margin = tolerance + _ROUNDED * max(1.0, min(np.abs(places).max(), _FARTHEST))
        found[number] = squared.max() <= margin * margin
    return found


def warm() -> None:
    """Call the kernels once."""
    scope, rows = np.uint64(1), np.zeros(1, np.int64)
    mixed(scope, rows)
    spots(np.ones(1, np.uint64), np.zeros((1, 4)), np.zeros(1), rows)
    buckets_near(scope, np.zeros(4), 0.25)
    may_join(rows, np.zeros(4), 0.25)
