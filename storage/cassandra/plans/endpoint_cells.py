"""Where plans lie in Cassandra: in a bucket, by the squares of their ends, and there at a spot.

The *spot* of a plan is one number: its length, so that in a bucket the shortest come first, then where in the squares
its ends lie, to two centimetres, and a hash of its planner and that one's parameters. Thousands of plans lie at few
spots where robots drive the same ways.
"""

import hashlib
import itertools
import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import msgspec
import numpy as np

from ppaas.plans.encoding.index_cells import Position, scope_of
from ppaas.plans.encoding.kernels.end_buckets import LENGTH_BITS, PER_METRE
from storage.encoding import encode
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord

EDGE = 2.0
"""Edge of the squares [m]. To open a bucket takes as long as to read some hundred plans in it: at a tolerance of an
eighth of the edge, which is common, two or three are opened, and seldom more than eight."""

_PART_BITS, _KIND_BYTES = 7, 2
_PARTS = 1 << _PART_BITS
_SHIFTS = np.arange(3, -1, -1) * _PART_BITS + 8 * _KIND_BYTES
_WIDTH = EDGE / _PARTS
_FARTHEST = 2.0**40
_PLACE = struct.Struct("<2d")
_POSE_BYTES = 56

Cell = tuple[bytes, int]
"""A bucket and a spot in it."""


def ends_of(record: PlanRecord) -> tuple[Position, Position]:
    """Return x, y of the first and the last pose [m]."""
    last = len(record.poses) - _POSE_BYTES
    return _PLACE.unpack_from(record.poses), _PLACE.unpack_from(record.poses, last)


def cell_key(record: PlanRecord) -> tuple[bytes, int, str]:
    """Return the key under which a plan lies: its bucket, its spot, and its id."""
    start, goal = ends_of(record)
    parts = [_part(value) for value in (*start, *goal)]
    spot = quantized_length(record.length)
    for part in parts:
        spot = spot << _PART_BITS | part % _PARTS
    spot = spot << 8 * _KIND_BYTES | _kind(record)
    bucket = _bucket(scope_of(record.map, record.version), [part // _PARTS for part in parts])
    return bucket, spot, record.id


def quantized_length(length: float) -> int:
    """Return a length [m] as spots tell it: in 16ths of a metre, rounded down; the longest are all the same."""
    return int(min(length * PER_METRE, (1 << LENGTH_BITS) - 1))


def length_of_cell(spot: int) -> int:
    """Return how long the plans at a spot are, as it tells it."""
    return spot >> 4 * _PART_BITS + 8 * _KIND_BYTES


class NearbyBuckets:
    """The buckets in which plans lie whose ends are near two places.

    Parameters
    ----------
    search : PlanStoreQuery
    """

    def __init__(self, search: PlanStoreQuery) -> None:
        self._at = [_limited(value) for value in (*search.start, *search.goal)]
        # What is rounded away must not hide a plan, nor make many buckets of a place far off.
        self._reach = search.tolerance + 2.0**-50 * max(1.0, *map(abs, self._at))
        ranges = [_bucket_range(value - self._reach, value + self._reach) for value in self._at]
        self._buckets = {_bucket(search.scope, squares): squares for squares in itertools.product(*ranges)}

    @property
    def buckets(self) -> list[bytes]:
        """Return the buckets."""
        return list(self._buckets)

    def connecting(self, spots: Sequence[Any]) -> list[Cell]:
        """Return those of some spots, rows with ``bucket`` and ``spot``, whose plans may lead from one to the other."""
        if not spots:
            return []
        squares = np.array([self._buckets[row.bucket] for row in spots], np.float64)
        parts = np.array([row.spot for row in spots], np.int64)[:, None] >> _SHIFTS & _PARTS - 1
        low = (squares * _PARTS + parts) * _WIDTH
        apart = np.maximum(np.maximum(low - self._at, self._at - low - _WIDTH), 0.0)
        farther = (apart * apart).reshape(-1, 2, 2).sum(axis=2).max(axis=1)
        return [
            (row.bucket, row.spot) for row, far in zip(spots, farther.tolist(), strict=True) if far <= self._reach**2
        ]


class _Kind(msgspec.Struct, frozen=True, array_like=True):
    planner: str
    parameters: dict[str, Any]


def _kind(record: PlanRecord) -> int:
    """Return a number for how a plan was made: few of each kind are looked at, and of another more may be wanted."""
    kind = encode(_Kind(record.planner, record.parameters))
    return int.from_bytes(hashlib.blake2b(kind, digest_size=_KIND_BYTES).digest())


def _limited(value: float) -> float:
    return min(max(value, -_FARTHEST), _FARTHEST)


def _part(value: float) -> int:
    """Return in which part of a square a coordinate lies, counted from zero on."""
    return math.floor(_limited(value) * (_PARTS / EDGE))


def _bucket_range(low: float, high: float) -> range:
    return range(_part(low) // _PARTS, _part(high) // _PARTS + 1)


def _bucket(scope: bytes, squares: Iterable[int]) -> bytes:
    return hashlib.blake2b(repr(tuple(squares)).encode(), digest_size=16, salt=scope).digest()
