"""Where plans are cut into stretches that other plans may share.

Content-defined chunks by local maximum: each waypoint has a hash, and a plan is cut before a waypoint whose hash is the
largest of all within G waypoints on either side. Whether it is cut there depends on these alone, so equal stretches are
cut equally wherever they lie, and nothing that is stored ever has to be cut again. Two cuts are more than G apart: no
stretch is shorter than G, and no plan of n waypoints has more than n / G.

N. Bjørner, A. Blass, Y. Gurevich, *Content-dependent chunking for differential compression, the local maximum
approach*, J. Computer and System Sciences 76 (2010).
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Poses

GRANULARITY = 16
"""The paper's: a length in waypoints. It divides a plan into stretches of which at most its length / G are shared, and
a shared stretch longer than it becomes an entry."""

MOST_GRANULARITY = 65536

ENDS_BEFORE, ENDS_AFTER = 1, 2
"""Waypoints that are never shared: the start, which lies anywhere in its cell, and the goal and the one before, which
heads for it."""

_FACTORS = np.array(
    [
        0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0xD6E8FEB86659FD93,
        0xA0761D6478BD642F, 0xE7037ED1A0B428DB, 0x8EBC6AF09C88C6E3,
    ],
    np.uint64,
)  # fmt: skip
_MIX = np.uint64(0xFF51AFD7ED558CCD)
_HALF = np.uint64(32)


def inner_granularity(granularity: int) -> int:
    """Return what to cut with for the paper's granularity: a half of it.

    A shared stretch that is little longer than G may hold no whole chunk of G, and mostly holds one of a half.

    Raises
    ------
    InvalidInput
        It is not a whole number from 2 to 65536.
    """
    if not 2 <= granularity <= MOST_GRANULARITY:
        raise InvalidInput(f"granularity: {granularity} is no number of waypoints from 2 to {MOST_GRANULARITY}")
    return granularity // 2


def waypoint_hashes(poses: Poses) -> NDArray[np.uint64]:
    """Return a hash of each of (n, 7) poses, the same on every machine."""
    words = np.ascontiguousarray(poses, "<f8").view("<u8")
    hashes: NDArray[np.uint64] = words @ _FACTORS
    hashes ^= hashes >> _HALF
    hashes *= _MIX
    hashes ^= hashes >> _HALF
    return hashes


def chunk_bounds(poses: Poses, stops: NDArray[np.int64], granularity: int) -> list[NDArray[np.int64]]:
    """Cut many plans at once.

    Parameters
    ----------
    poses : (n, 7) array
        Those of all plans, one plan after the other.
    stops : (m,) array
        For each plan the row behind its last pose.
    granularity : int
        G, one at least.

    Returns
    -------
    list of (k + 1,) array
        For each plan the rows between which its k chunks lie; what is before the first and behind the last is not
        shared. Fewer than G waypoints between these ends are no chunk, and have no bounds.
    """
    first = np.concatenate(([0], stops[:-1])) + ENDS_BEFORE
    last = stops - ENDS_AFTER
    cuts = np.flatnonzero(_is_largest(waypoint_hashes(poses), granularity))
    begins = np.searchsorted(cuts, first + granularity)
    ends = np.searchsorted(cuts, last - granularity)
    bounds = []
    for a, b, begin, end in zip(first.tolist(), last.tolist(), begins.tolist(), ends.tolist(), strict=True):
        if b - a < granularity:
            bounds.append(np.empty(0, np.int64))
        else:
            bounds.append(np.concatenate(([a], cuts[begin:end], [b])))
    return bounds


def _is_largest(hashes: NDArray[np.uint64], granularity: int) -> NDArray[np.bool_]:
    """Tell of each hash whether it is the largest within ``granularity`` before and behind; of equal ones the last."""
    found = np.zeros(len(hashes), np.bool_)
    if len(hashes) > 2 * granularity:
        beside = _sliding_maximum(hashes, granularity)
        inner = hashes[granularity:-granularity]
        found[granularity:-granularity] = (inner >= beside[: len(inner)]) & (inner > beside[granularity + 1 :])
    return found


def _sliding_maximum(values: NDArray[np.uint64], width: int) -> NDArray[np.uint64]:
    """Return the maximum of each ``width`` values that follow one another."""
    largest, seen = values, 1
    while seen < width:
        step = min(seen, width - seen)
        largest = np.maximum(largest[:-step], largest[step:])
        seen += step
    return largest
