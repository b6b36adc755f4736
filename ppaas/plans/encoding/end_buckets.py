"""Index of plans by their ends: a search for plans between two positions reads only a few buckets.

The plane is divided into cells, and a plan belongs to one pair of a start cell and a goal cell. Its *index key* is one
number: the bucket, a hash of that pair; then the length, so that the shortest plans of a bucket come first; then the
subcells in which the ends lie, so that most plans that are too far away are skipped unread. A key may match by chance,
so the reader checks the plan itself.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.plans.encoding.index_cells import Position
from ppaas.plans.encoding.kernels import end_buckets

EDGE = end_buckets.EDGE
"""Edge of a cell [m]. At the common tolerance of half an edge, a search reads 16 buckets (more if a position is exactly
on a corner of a cell)."""

IN_BUCKET = (1 << end_buckets.LENGTH_BITS + end_buckets.END_BITS) - 1
"""Mask of the bits of a key below its bucket."""

_SUBCELL = end_buckets.SUBCELLS - 1


def index_keys_of(
    scopes: Sequence[bytes], ends: NDArray[np.float64], lengths: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the index keys of plans, from 0 to 2⁶³ − 1.

    Parameters
    ----------
    scopes : sequence of bytes
        Scope of the map version of each plan.
    ends : (m, 4) float64 array
        x, y of their ends [m].
    lengths : (m,) float64 array
        Lengths of the plans [m].
    """
    found = np.empty(len(ends), np.int64)
    words = np.array([_word(scope) for scope in scopes], np.uint64)
    end_buckets.index_keys(words, ends, lengths, found)
    return found


def length_of_key(key: int) -> int:
    """Return the length of the plan with a key [1/16 m]; the longest plans all have the same value."""
    return key >> end_buckets.END_BITS & (1 << end_buckets.LENGTH_BITS) - 1


def bucket_of_key(key: int) -> int:
    """Return the bucket of a key."""
    return key >> end_buckets.LENGTH_BITS + end_buckets.END_BITS


def buckets_near(scope: bytes, start: Position, goal: Position, tolerance: float) -> NDArray[np.int64]:
    """Return the buckets of plans whose ends may lie within a tolerance of two positions [m].

    Returns
    -------
    (k, 10) int64 array
        Of each bucket the first and the last key; then, for x and y of start and goal, the first and the last subcell
        in which an end may lie.
    """
    return end_buckets.buckets_near(_word(scope), np.array((*start, *goal), np.float64), tolerance)


def may_join(keys: NDArray[np.int64], start: Position, goal: Position, tolerance: float) -> NDArray[np.bool_]:
    """Return for (n,) keys of such buckets whether the ends may lie within a tolerance of two positions [m]."""
    return end_buckets.may_join(keys, np.array((*start, *goal), np.float64), tolerance)


def holds(bucket: Sequence[int], key: int) -> bool:
    """Return whether the ends of the plan with a key of a bucket may match the search."""
    # Plain comparisons: a busy bucket has some hundred keys.
    _, _, low_x, high_x, low_y, high_y, low_goal_x, high_goal_x, low_goal_y, high_goal_y = bucket
    return (
        low_x <= key >> 3 * end_buckets.SUBCELL_BITS & _SUBCELL <= high_x
        and low_y <= key >> 2 * end_buckets.SUBCELL_BITS & _SUBCELL <= high_y
        and low_goal_x <= key >> end_buckets.SUBCELL_BITS & _SUBCELL <= high_goal_x
        and low_goal_y <= key & _SUBCELL <= high_goal_y
    )


def cell_number(scope: bytes, cell: tuple[int, int]) -> int:
    """Return a 31-bit number for a cell with the edge ``CELL_EDGE``."""
    return int(end_buckets.mixed(_word(scope), np.array(cell, np.int64))) >> 33


def _word(scope: bytes) -> np.uint64:
    return np.uint64(int.from_bytes(scope[:8], "little"))
