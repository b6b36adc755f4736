"""Buckets of plans by where they begin and end: those between two places are found without looking at others.

The plane is cut into squares, so a plan lies in one of a start square and a goal square. Its *spot* is one number: the
bucket, by a hash; then the length, so that in a bucket the shortest come first; then where in its squares the ends lie,
roughly, so that most of what lies too far off is passed over unread. A spot may match by chance: whoever finds one
looks at the plan itself.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.plans.encoding.index_cells import Position
from ppaas.plans.encoding.kernels import end_buckets

EDGE = end_buckets.EDGE
"""Edge of a square [m]: at a tolerance of a half of it, which is common, what is sought lies in 16 buckets, but for
places right on a corner."""

IN_BUCKET = (1 << end_buckets.LENGTH_BITS + end_buckets.END_BITS) - 1
"""The bits of a spot behind its bucket."""

_PART = end_buckets.PARTS - 1


def index_keys_of(
    scopes: Sequence[bytes], ends: NDArray[np.float64], lengths: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the spots of plans, from 0 to 2⁶³ − 1.

    Parameters
    ----------
    scopes : sequence of bytes
        Of the version of a map of each.
    ends : (m, 4) array
        x, y of their ends [m].
    lengths : (m,) array
        [m]
    """
    found = np.empty(len(ends), np.int64)
    words = np.array([_word(scope) for scope in scopes], np.uint64)
    end_buckets.spots(words, ends, lengths, found)
    return found


def length_of_key(spot: int) -> int:
    """Return the length of the plan at a spot in 16ths of a metre; the longest are all the same."""
    return spot >> end_buckets.END_BITS & (1 << end_buckets.LENGTH_BITS) - 1


def bucket_of_key(spot: int) -> int:
    """Return the bucket of a spot."""
    return spot >> end_buckets.LENGTH_BITS + end_buckets.END_BITS


def buckets_near(scope: bytes, start: Position, goal: Position, tolerance: float) -> NDArray[np.int64]:
    """Return the buckets in which plans lie whose ends are within a tolerance of two places [m].

    Returns
    -------
    (k, 10) array
        Of each bucket the first spot and the last, and of x and y of start and goal the first and the last part of
        their squares in which they may lie.
    """
    return end_buckets.buckets_near(_word(scope), np.array((*start, *goal), np.float64), tolerance)


def may_join(spots: NDArray[np.int64], start: Position, goal: Position, tolerance: float) -> NDArray[np.bool_]:
    """Tell of (n,) spots in such buckets whether the plans may begin and end within a tolerance of two places [m]."""
    return end_buckets.may_join(spots, np.array((*start, *goal), np.float64), tolerance)


def holds(bucket: Sequence[int], spot: int) -> bool:
    """Tell whether a spot of a bucket may be that of a plan sought."""
    # One by one: in a busy bucket this is asked of some hundred spots.
    _, _, low_x, high_x, low_y, high_y, low_goal_x, high_goal_x, low_goal_y, high_goal_y = bucket
    return (
        low_x <= spot >> 3 * end_buckets.PART_BITS & _PART <= high_x
        and low_y <= spot >> 2 * end_buckets.PART_BITS & _PART <= high_y
        and low_goal_x <= spot >> end_buckets.PART_BITS & _PART <= high_goal_x
        and low_goal_y <= spot & _PART <= high_goal_y
    )


def cell_number(scope: bytes, square: tuple[int, int]) -> int:
    """Return a number of 31 bits for a square of ``CELL_EDGE``."""
    return int(end_buckets.mixed(_word(scope), np.array(square, np.int64))) >> 33


def _word(scope: bytes) -> np.uint64:
    return np.uint64(int.from_bytes(scope[:8], "little"))
