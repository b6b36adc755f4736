"""Kernel: index keys of plans by their ends (``ppaas.plans.encoding.end_buckets``)."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Numbers = NDArray[np.float64]
Rows = NDArray[np.int64]

EDGE = 0.5
"""Edge of a cell [m]."""

SUBCELL_BITS, LENGTH_BITS, PER_METRE = 6, 18, 16
"""Bits of a subcell along one axis, bits of the length, and units of the length per metre."""

SUBCELLS, END_BITS = 1 << SUBCELL_BITS, 4 * SUBCELL_BITS
"""Subcells along the edge of a cell, and bits of the four subcells of both ends."""

COLUMNS = 10
"""Columns of a bucket: its first and last key; then for x and y of start and goal, the first and last subcell of a
match."""

_FARTHEST = 2.0**40
_ROUNDING = 2.0**-50
_BUCKET_BITS = 63 - LENGTH_BITS - END_BITS
_ODD, _LAST = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9)
_SHIFT = np.uint64(29)


@compiled
def mixed(scope: np.uint64, numbers: Rows) -> np.uint64:
    """Return a fast 64-bit hash. Matches are checked, so collisions do no harm."""
    word = scope
    for number in numbers:
        word = (word ^ np.uint64(number)) * _ODD
        word ^= word >> _SHIFT
    return word * _LAST


@compiled
def _subcell(value: float) -> int:
    """Return the subcell of a coordinate, counted from zero."""
    return int(np.floor(_in_subcells(value)))


@compiled
def _in_subcells(value: float) -> float:
    return min(max(value / EDGE, -_FARTHEST), _FARTHEST) * SUBCELLS


@compiled
def _bucket(scope: np.uint64, cells: Rows) -> int:
    return int(np.int64(mixed(scope, cells) >> np.uint64(64 - _BUCKET_BITS)))


@compiled
def index_keys(scopes: NDArray[np.uint64], ends: Numbers, lengths: Numbers, found: Rows) -> None:
    """Write the index keys of plans.

    Parameters
    ----------
    scopes : (m,) uint64 array
        Scope of the map version of each plan.
    ends : (m, 4) float64 array
        x, y of their ends [m].
    lengths : (m,) float64 array
        Lengths of the plans [m].
    found : (m,) int64 array
        Out: the keys.
    """
    cells = np.empty(4, np.int64)
    for plan in range(len(ends)):
        subcells = 0
        for side in range(4):
            subcell = _subcell(ends[plan, side])
            cells[side] = subcell // SUBCELLS
            subcells = subcells << SUBCELL_BITS | subcell % SUBCELLS
        length = min(int(min(lengths[plan], 1e9) * PER_METRE), (1 << LENGTH_BITS) - 1)
        found[plan] = (_bucket(scopes[plan], cells) << LENGTH_BITS | length) << END_BITS | subcells


@compiled
def buckets_near(scope: np.uint64, positions: Numbers, tolerance: float) -> Rows:
    """Return (k, ``COLUMNS``): the buckets of plans whose ends may lie within a tolerance of two positions.

    Parameters
    ----------
    scope : uint64
        Scope of the map version.
    positions : (4,) float64 array
        x, y of start and goal [m].
    tolerance : float
        Largest distance of an end [m].
    """
    lows, highs = np.empty(4, np.int64), np.empty(4, np.int64)
    count = 1
    for side in range(4):
        # Allow for rounding, which must neither hide a plan nor yield thousands of buckets for a distant position.
        margin = tolerance + _ROUNDING * max(1.0, min(abs(positions[side]), _FARTHEST))
        lows[side], highs[side] = _subcell(positions[side] - margin), _subcell(positions[side] + margin)
        count *= highs[side] // SUBCELLS - lows[side] // SUBCELLS + 1
    found, cells = np.empty((count, COLUMNS), np.int64), np.empty(4, np.int64)
    for number in range(count):
        left = number
        for side in range(3, -1, -1):
            first = lows[side] // SUBCELLS
            left, offset = divmod(left, highs[side] // SUBCELLS - first + 1)
            cells[side] = first + offset
            begin = cells[side] * SUBCELLS
            found[number, 2 + 2 * side] = max(lows[side] - begin, 0)
            found[number, 3 + 2 * side] = min(highs[side] - begin, SUBCELLS - 1)
        found[number, 0] = _bucket(scope, cells) << LENGTH_BITS + END_BITS
        found[number, 1] = found[number, 0] + (1 << LENGTH_BITS + END_BITS) - 1
    return found


@compiled
def may_join(keys: Rows, positions: Numbers, tolerance: float) -> NDArray[np.bool_]:
    """Return for (n,) keys of `buckets_near` whether both ends may lie within a tolerance of their positions.

    A key gives the subcell of an end but not its cell: of all such subcells, the nearest to the position counts.
    """
    found = np.empty(len(keys), np.bool_)
    width = EDGE / SUBCELLS
    for number in range(len(keys)):
        squared = np.zeros(2)
        for side in range(4):
            subcell = keys[number] >> SUBCELL_BITS * (3 - side) & SUBCELLS - 1
            # Distance from the middle of the subcell to the position, in subcells, in both directions.
            apart = (_in_subcells(positions[side]) - subcell - 0.5) % SUBCELLS
            apart = max(min(apart, SUBCELLS - apart) - 0.5, 0.0) * width
            squared[side // 2] += apart * apart
        margin = tolerance + _ROUNDING * max(1.0, min(np.abs(positions).max(), _FARTHEST))
        found[number] = squared.max() <= margin * margin
    return found


def warm() -> None:
    """Call the kernels once."""
    scope, rows = np.uint64(1), np.zeros(1, np.int64)
    mixed(scope, rows)
    index_keys(np.ones(1, np.uint64), np.zeros((1, 4)), np.zeros(1), rows)
    buckets_near(scope, np.zeros(4), 0.25)
    may_join(rows, np.zeros(4), 0.25)
