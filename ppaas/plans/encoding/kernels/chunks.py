"""Kernel: hashes of waypoints, and the cuts of plans at their local maxima."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Words = NDArray[np.uint64]
Rows = NDArray[np.int64]

FACTORS = (
    0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93,
    0xA0761D6478BD642F, 0xE7037ED1A0B428DB, 0x8EBC6AF09C88C6E3,
)  # fmt: skip
"""Multipliers of the seven numbers of a pose."""

MIX = 0xFF51AFD7ED558CCD
"""Multiplier of the final mix."""

ENDS_BEFORE, ENDS_AFTER = 1, 2
"""Number of waypoints that are never shared: the start, which may be anywhere in its cell; and the goal and the
waypoint before it, which faces it."""

_FACTORS = np.array(FACTORS, np.uint64)
_MIX, _HALF = np.uint64(MIX), np.uint64(32)
_INFINITE = np.uint64(0x7FF) << np.uint64(52)


@compiled
def hash_waypoints(words: Words, hashes: Words) -> int:
    """Write the hash of each of (n, 7) poses, given by their bits; return the first row that is not finite, or -1."""
    for row in range(len(words)):
        mixed = np.uint64(0)
        for column in range(7):
            word = words[row, column]
            mixed += word * _FACTORS[column]
            if word & _INFINITE == _INFINITE:
                return row
        mixed = (mixed ^ mixed >> _HALF) * _MIX
        hashes[row] = mixed ^ mixed >> _HALF
    return -1


@compiled
def cut(words: Words, stops: Rows, granularity: int, begins: Rows, ends: Rows, parts: Rows) -> int:
    """Cut plans before each waypoint whose hash is the maximum within G waypoints on both sides.

    Of equal hashes, the last one counts.

    Parameters
    ----------
    words : (n, 7) uint64 array
        Bits of the poses of all plans, one plan after the other.
    stops : (m,) int64 array
        For each plan the row after its last waypoint.
    granularity : int
        G.
    begins, ends : (k,) int64 array
        Out: rows of the segments, the end excluded; k is at least n // G + m.
    parts : (m,) int64 array
        Out: for each plan the index after its last segment. A plan without waypoints between its ends has none.

    Returns
    -------
    int
        The first row that is not finite, in which case nothing is cut; or -1.
    """
    hashes = np.empty(len(words), np.uint64)
    bad_row = hash_waypoints(words, hashes)
    if bad_row >= 0:
        return bad_row
    at = previous_stop = 0
    for plan in range(len(stops)):
        first, last = previous_stop + ENDS_BEFORE, stops[plan] - ENDS_AFTER
        previous_stop = stops[plan]
        # Segments between the waypoints at the ends.
        if last > first:
            begins[at] = first
            # Of G + 1 consecutive waypoints only the maximum can be a cut.
            for begin in range(first + granularity, last - granularity, granularity + 1):
                best = begin
                for row in range(begin + 1, min(begin + granularity + 1, last - granularity)):
                    if hashes[row] >= hashes[best]:
                        best = row
                if _is_largest(hashes, best, granularity):
                    ends[at] = best
                    at += 1
                    begins[at] = best
            ends[at] = last
            at += 1
        parts[plan] = at
    return -1


@compiled
def _is_largest(hashes: Words, row: int, granularity: int) -> bool:
    for step in range(1, granularity + 1):
        if hashes[row - step] > hashes[row] or hashes[row + step] >= hashes[row]:
            return False
    return True


def warm() -> None:
    """Call the kernels once."""
    words = np.zeros((3, 7), np.uint64)
    words.flags.writeable = False
    hash_waypoints(words, np.empty(3, np.uint64))
    rows = np.empty(4, np.int64)
    cut(words, np.array([3]), 1, rows, rows, np.empty(1, np.int64))
