"""Kernel: hashes of waypoints, and where they cut plans."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Words = NDArray[np.uint64]
Rows = NDArray[np.int64]

FACTORS = (
    0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93,
    0xA0761D6478BD642F, 0xE7037ED1A0B428DB, 0x8EBC6AF09C88C6E3,
)  # fmt: skip
"""For the seven numbers of a pose."""

MIX = 0xFF51AFD7ED558CCD

ENDS_BEFORE, ENDS_AFTER = 1, 2
"""Waypoints that are never shared: the start, which lies anywhere in its cell, and the goal and the one before, which
heads for it."""

_FACTORS = np.array(FACTORS, np.uint64)
_MIX, _HALF = np.uint64(MIX), np.uint64(32)
_INFINITE = np.uint64(0x7FF) << np.uint64(52)


@njit(cache=True, nogil=True, error_model="numpy")
def hash_waypoints(words: Words, hashes: Words) -> int:
    """Write the hash of each of (n, 7) poses, told by their bits; return the first that is not finite, or -1."""
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


@njit(cache=True, nogil=True, error_model="numpy")
def cut(words: Words, stops: Rows, granularity: int, begins: Rows, ends: Rows, parts: Rows) -> int:
    """Cut plans before each waypoint whose hash is the largest within G before and behind, of equal ones the last.

    Parameters
    ----------
    words : (n, 7) array
        The bits of the poses of all plans, one plan after the other.
    stops : (m,) array
        For each plan the row behind its last waypoint.
    granularity : int
        G.
    begins, ends : (k,) array
        Get the rows of the stretches: so many as waypoints hold G, and one for each plan.
    parts : (m,) array
        Gets for each plan where its stretches end; it has none where nothing is between its own waypoints.

    Returns
    -------
    int
        The first row that is not finite, and then nothing is cut, or -1.
    """
    hashes = np.empty(len(words), np.uint64)
    infinite = hash_waypoints(words, hashes)
    if infinite >= 0:
        return infinite
    at = before = 0
    for plan in range(len(stops)):
        first, last = before + ENDS_BEFORE, stops[plan] - ENDS_AFTER
        before = stops[plan]
        if last > first:
            begins[at] = first
            # Of so many that follow one another only the largest can be a cut.
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


@njit(cache=True, nogil=True, error_model="numpy")
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
