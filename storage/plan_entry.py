"""A plan as stores keep it: what many plans have in common, what is its own, and the stretches that it shares."""

import itertools
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import msgspec
import numpy as np

from ppaas.geometry import Poses
from ppaas.plans.encoding.body import PlanBody, read_body, write_bodies
from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE, cut_plans, words_of
from ppaas.plans.encoding.codes import codes_of
from ppaas.plans.encoding.end_buckets import index_keys_of
from ppaas.plans.encoding.index_cells import scope_of
from storage.encoding import decode, encode
from storage.plan_checks import POSE_BYTES, check_plans
from storage.records import PlanOrigin, PlanRecord

_AT_ONCE = 128
"""Plans that are cut together: so many that a call costs nothing, and so few that they stay in the cache."""


class PlanContext(msgspec.Struct, frozen=True, array_like=True):
    """What many plans have in common."""

    user: str
    map: str
    version: str
    planner: str
    robot: str | None
    origin: PlanOrigin
    parameters: dict[str, Any]


class PlanEntry(msgspec.Struct, frozen=True):
    """What is kept of a plan. No dataclass, as ``ppaas.plans.encoding.body.PlanBody``.

    Parameters
    ----------
    id, map : str
    context : bytes
        A ``PlanContext``, encoded.
    scope : bytes
        Of its version of a map.
    created : float
    waypoints : int
    spot : int
        Where it is looked for (``ppaas.plans.encoding.end_buckets``).
    body : bytes
        What is its own (``ppaas.plans.encoding.body``).
    codes : list of bytes
        The stretches that it shares, in their order (``ppaas.plans.encoding.codes``).
    shared : int
        Waypoints in these.
    """

    id: str
    map: str
    context: bytes
    scope: bytes
    created: float
    waypoints: int
    spot: int
    body: bytes
    codes: list[bytes]
    shared: int

    @property
    def loose(self) -> int:
        """Return how many waypoints are kept for this plan alone."""
        return self.waypoints - self.shared


def entries_of(records: Iterable[PlanRecord], granularity: int) -> Iterator[PlanEntry]:
    """Yield what is kept of plans.

    Raises
    ------
    InvalidInput
        One cannot be kept (``storage.plan_checks``).
    """
    left = iter(records)
    while batch := list(itertools.islice(left, _AT_ONCE)):
        yield from _entries(batch, granularity)


def context_of(data: bytes) -> PlanContext:
    """Return what was encoded; its parameters are the caller's own, unless they are none."""
    common = _remembered(data)
    return decode(data, PlanContext) if common.parameters else common


def head_of(context: bytes, own: PlanBody) -> PlanRecord:
    """Return the head of a plan."""
    return _record(context_of(context), own, b"")


def record_of(context: bytes, body: bytes, shared: list[Poses]) -> PlanRecord:
    """Return a plan, of the stretches that it shares."""
    own = read_body(body)
    return _record(context_of(context), own, own.poses(shared).astype("<f8", copy=False).tobytes())


@lru_cache(1 << 10)
def _remembered(data: bytes) -> PlanContext:
    """Return what was encoded: of the plans that a search finds most have the same in common."""
    return decode(data, PlanContext)


def _entries(records: list[PlanRecord], granularity: int) -> Iterator[PlanEntry]:
    poses = check_plans(records)
    contexts = [encode(_context(record)) for record in records]
    counts = [len(record.poses) // POSE_BYTES for record in records]
    words, stops = words_of(poses), np.array(list(itertools.accumulate(counts)), np.int64)
    cuts = cut_plans(words, stops, granularity)
    codes, first, mine = codes_of(poses, cuts.begins, cuts.ends), 0, []
    for stop in cuts.parts.tolist():
        mine.append(codes[first:stop])
        first = stop
    shared = cuts.shared.tolist()
    between = [None if is_shared or not each else each[0] for each, is_shared in zip(mine, shared, strict=True)]
    bodies, ends = write_bodies([record.id for record in records], list(map(_numbers, records)), words, stops, between)
    scopes = [scope_of(record.map, record.version) for record in records]
    spots = index_keys_of(scopes, ends, np.array([record.length for record in records], np.float64)).tolist()
    for record, context, scope, count, spot, body, own, is_shared in zip(
        records, contexts, scopes, counts, spots, bodies, mine, shared, strict=True
    ):
        yield PlanEntry(
            record.id, record.map, context, scope, record.created, count, spot, body, own if is_shared else [],
            count - ENDS_BEFORE - ENDS_AFTER if is_shared else 0,
        )  # fmt: skip


def _context(record: PlanRecord) -> PlanContext:
    return PlanContext(
        record.user, record.map, record.version, record.planner, record.robot, record.origin, record.parameters
    )


def _numbers(record: PlanRecord) -> tuple[float, ...]:
    return (record.created, record.length, record.cost, record.seconds, *record.start, *record.goal)


def _record(common: PlanContext, own: PlanBody, poses: bytes) -> PlanRecord:
    created, length, cost, seconds, *ends = own.numbers()
    return PlanRecord(
        id=own.plan_id, user=common.user, map=common.map, version=common.version, planner=common.planner,
        start=(ends[0], ends[1], ends[2]), goal=(ends[3], ends[4], ends[5]), length=length, cost=cost, seconds=seconds,
        poses=poses, created=created, robot=common.robot, parameters=common.parameters or {}, origin=common.origin,
    )  # fmt: skip
