"""A plan as a row: its head, the poses at its ends, and a recipe of the entries between them."""

import hashlib
import itertools
import math
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import msgspec
import numpy as np

from ppaas.errors import Unavailable
from ppaas.plans.buckets import EDGE, Place, scope_of
from ppaas.plans.chunks import chunk_bounds
from ppaas.plans.codes import codes_of, entry_id, pack
from storage.encoding import encode
from storage.plan_checks import POSE_BYTES, array_of
from storage.records import PlanRecord
from storage.versions import without_poses

_PART = struct.Struct("<16sII")

MOST_PARTS = 256
"""Parts in a row: a longer recipe is cut into entries of its own, so that no row grows large."""


class Part(NamedTuple):
    """An entry in a recipe: its id, how many waypoints it has, and how many bytes."""

    entry: bytes
    waypoints: int
    size: int


@dataclass(frozen=True)
class PlanRow:
    """What is kept of a plan.

    Parameters
    ----------
    record : PlanRecord
        As it was given.
    scope : bytes
        Of its version of a map.
    before : int
        Poses before the first entry; those behind the last follow them in ``ends``.
    ends : bytes
        Poses that no entry holds.
    recipe : bytes
        Parts, one after the other.
    depth : int
        How often the recipe had to be cut into entries: what its parts hold are recipes, where it is not 0.
    entries : dict
        What the parts name, as it is kept.
    """

    record: PlanRecord
    scope: bytes
    before: int
    ends: bytes
    recipe: bytes
    depth: int
    entries: dict[bytes, bytes]

    @cached_property
    def head(self) -> bytes:
        """The plan without its poses."""
        return encode(without_poses(self.record))

    @property
    def places(self) -> tuple[Place, Place]:
        """x, y of the first and the last pose [m]."""
        poses = array_of(self.record.poses)
        return (float(poses[0, 0]), float(poses[0, 1])), (float(poses[-1, 0]), float(poses[-1, 1]))


_packed = lru_cache(1 << 14)(pack)  # most stretches of a plan were met before


def plan_rows(records: Sequence[PlanRecord], granularity: int) -> Iterator[PlanRow]:
    """Yield the rows of plans, which are cut together: one by one takes several times as long."""
    if not records:
        return
    poses = array_of(b"".join(record.poses for record in records))
    stops = np.cumsum([len(record.poses) // POSE_BYTES for record in records])
    bounds = chunk_bounds(poses, stops, granularity)
    begins = np.concatenate([one[:-1] for one in bounds])
    ends = np.concatenate([one[1:] for one in bounds])
    codes = iter(codes_of(poses, begins, ends))
    first = 0
    for record, stop, cuts in zip(records, stops.tolist(), bounds, strict=True):
        yield _row(record, cuts.tolist(), first, stop, codes)
        first = stop


def _row(record: PlanRecord, cuts: list[int], first: int, stop: int, codes: Iterator[bytes]) -> PlanRow:
    scope = scope_of(record.map, record.version)
    parts, entries = [], {}
    for begin, end in itertools.pairwise(cuts):
        code = next(codes)
        number = entry_id(scope, code)
        entries[number] = _packed(code)
        parts.append(Part(number, end - begin, len(entries[number])))
    before = (cuts[0] if cuts else stop) - first
    behind = stop - cuts[-1] if cuts else 0
    size = len(record.poses)
    ends = record.poses[: before * POSE_BYTES] + record.poses[size - behind * POSE_BYTES :]
    depth = 0
    while len(parts) > MOST_PARTS:
        groups = [parts[at : at + MOST_PARTS] for at in range(0, len(parts), MOST_PARTS)]
        parts = [_recipe_entry(scope, group, entries) for group in groups]
        depth += 1
    return PlanRow(record, scope, before, ends, write_parts(parts), depth, entries)


def _recipe_entry(scope: bytes, parts: list[Part], entries: dict[bytes, bytes]) -> Part:
    data = write_parts(parts)
    number = entry_id(scope, data)
    entries[number] = data
    return Part(number, sum(part.waypoints for part in parts), len(data))


def write_parts(parts: Iterable[Part]) -> bytes:
    """Return parts as bytes."""
    return b"".join(_PART.pack(*part) for part in parts)


def read_parts(recipe: bytes) -> list[Part]:
    """Return the parts of a recipe.

    Raises
    ------
    Unavailable
        The bytes end within a part.
    """
    if len(recipe) % _PART.size:
        raise Unavailable("a stored recipe is damaged: restore it from a backup")
    return [Part(*fields) for fields in _PART.iter_unpack(recipe)]


def with_poses(head: PlanRecord, poses: bytes) -> PlanRecord:
    """Return a plan of its head and its poses."""
    return msgspec.structs.replace(head, poses=poses)


# -- where plans are looked for ----------------------------------------------------------------------------------------


def bucket_of(scope: bytes, start: Place, goal: Place) -> bytes:
    """Return the bucket of the plans that lead from one square of ``EDGE`` to another."""
    return _bucket(scope, [math.floor(value / EDGE) for value in (*start, *goal)])


def buckets_near(scope: bytes, start: Place, goal: Place, tolerance: float) -> list[bytes]:
    """Return the buckets of all plans with ends within a tolerance of two places [m]."""
    sides = [_near(value, tolerance, EDGE) for value in (*start, *goal)]
    return [_bucket(scope, squares) for squares in itertools.product(*sides)]


def _near(value: float, tolerance: float, edge: float) -> range:
    margin = tolerance + 1e-9 * max(1.0, abs(value))  # what is rounded away must not hide a plan
    low, high = (math.floor(min(max((value + side * margin) / edge, -(2.0**30)), 2.0**30)) for side in (-1, 1))
    return range(low, high + 1)


def _bucket(scope: bytes, squares: Iterable[int]) -> bytes:
    return hashlib.blake2b(repr(tuple(squares)).encode(), digest_size=16, salt=scope).digest()
