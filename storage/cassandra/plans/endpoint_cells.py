"""Index of plans by their ends in Cassandra: the bucket of a plan, and its cell in the bucket.

The plane is divided into squares of `EDGE`. The *bucket* of a plan is a hash of the squares of its start and goal, and
a partition of Cassandra. Its *cell* in the bucket is one number, the column ``spot``: the length, so that the shortest
plans of a bucket come first; then the positions of the ends within their squares, to two centimetres; then a hash of
the planner and its parameters. Robots that drive the same routes put thousands of plans into few cells.
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
from storage.encoding import encode_plain
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord

EDGE = 2.0
"""Edge of the squares [m]. Opening a bucket costs as much as reading a hundred plans in it: at a common tolerance of an
eighth of the edge, a search opens two or three buckets, and rarely more than eight."""

_PART_BITS, _KIND_BYTES = 7, 2
_PARTS = 1 << _PART_BITS
_SHIFTS = np.arange(3, -1, -1) * _PART_BITS + 8 * _KIND_BYTES
_WIDTH = EDGE / _PARTS
_FARTHEST = 2.0**40
_PLACE = struct.Struct("<2d")
_POSE_BYTES = 56

Cell = tuple[bytes, int]
"""Bucket and spot: a cell of the index."""


def ends_of(record: PlanRecord) -> tuple[Position, Position]:
    """Return x, y [m] of the first and the last pose."""
    last = len(record.poses) - _POSE_BYTES
    return _PLACE.unpack_from(record.poses), _PLACE.unpack_from(record.poses, last)


def cell_key(record: PlanRecord) -> tuple[bytes, int, str]:
    """Return the primary key of a plan in the index: its bucket, its spot, and its id."""
    start, goal = ends_of(record)
    parts = [_part(value) for value in (*start, *goal)]
    spot = quantized_length(record.length)
    for part in parts:
        spot = spot << _PART_BITS | part % _PARTS
    spot = spot << 8 * _KIND_BYTES | _kind(record)
    bucket = _bucket(scope_of(record.map, record.version), [part // _PARTS for part in parts])
    return bucket, spot, record.id


def quantized_length(length: float) -> int:
    """Return a length [m] in the unit of cells, 1/16 m, rounded down; the longest plans all have the same value."""
    return int(min(length * PER_METRE, (1 << LENGTH_BITS) - 1))


def length_of_cell(spot: int) -> int:
    """Return the length of the plans in a cell [1/16 m]."""
    return spot >> 4 * _PART_BITS + 8 * _KIND_BYTES


class NearbyBuckets:
    """The buckets of plans whose ends may be near two places.

    Parameters
    ----------
    search : PlanStoreQuery
    """

    def __init__(self, search: PlanStoreQuery) -> None:
        self._at = [_limited(value) for value in (*search.start, *search.goal)]
        # A margin for rounding errors, so that no plan is missed; bounded, so that a far place has few buckets.
        self._reach = search.tolerance + 2.0**-50 * max(1.0, *map(abs, self._at))
        ranges = [_square_range(value - self._reach, value + self._reach) for value in self._at]
        self._squares_of = {_bucket(search.scope, squares): squares for squares in itertools.product(*ranges)}

    @property
    def ids(self) -> list[bytes]:
        """Ids of the buckets."""
        return list(self._squares_of)

    def connecting(self, cells: Sequence[Any]) -> list[Cell]:
        """Return the cells, given as rows with ``bucket`` and ``spot``, whose plans may connect the two places."""
        if not cells:
            return []
        squares = np.array([self._squares_of[row.bucket] for row in cells], np.float64)
        parts = np.array([row.spot for row in cells], np.int64)[:, None] >> _SHIFTS & _PARTS - 1
        # Distance of each place from the rectangle that contains the end, first per axis, then squared per end.
        low = (squares * _PARTS + parts) * _WIDTH
        apart = np.maximum(np.maximum(low - self._at, self._at - low - _WIDTH), 0.0)
        farther = (apart * apart).reshape(-1, 2, 2).sum(axis=2).max(axis=1)
        return [
            (row.bucket, row.spot) for row, far in zip(cells, farther.tolist(), strict=True) if far <= self._reach**2
        ]


class _Kind(msgspec.Struct, frozen=True, array_like=True):
    planner: str
    parameters: dict[str, Any]


def _kind(record: PlanRecord) -> int:
    """Return a hash of planner and parameters, so that plans of different kinds are in different cells."""
    kind = encode_plain(_Kind(record.planner, record.parameters))
    return int.from_bytes(hashlib.blake2b(kind, digest_size=_KIND_BYTES).digest())


def _limited(value: float) -> float:
    return min(max(value, -_FARTHEST), _FARTHEST)


def _part(value: float) -> int:
    """Return the part that contains a coordinate [m]; parts of `EDGE` / 128 are counted from the origin."""
    return math.floor(_limited(value) * (_PARTS / EDGE))


def _square_range(low: float, high: float) -> range:
    return range(_part(low) // _PARTS, _part(high) // _PARTS + 1)


def _bucket(scope: bytes, squares: Iterable[int]) -> bytes:
    return hashlib.blake2b(repr(tuple(squares)).encode(), digest_size=16, salt=scope).digest()
