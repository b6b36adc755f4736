"""A plan in parts, as stores keep it: the context that many plans have in common, its body, and shared segments."""

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
from storage.encoding import decode, encode_plain
from storage.plan_checks import POSE_BYTES, check_plans
from storage.records import PlanOrigin, PlanRecord

_AT_ONCE = 128
"""Plans that are cut in one call: enough to make its overhead small, few enough to stay in the CPU's cache."""


class PlanContext(msgspec.Struct, frozen=True, array_like=True):
    """Fields that many plans have in common. Their order is part of the stored format."""

    user: str
    map: str
    version: str
    planner: str
    robot: str | None
    origin: PlanOrigin
    parameters: dict[str, Any]


class PlanEntry(msgspec.Struct, frozen=True):
    """The parts of a plan. A struct, because it is created faster than a dataclass.

    Parameters
    ----------
    id, map : str
        Ids of the plan and of its map.
    context : bytes
        Encoded ``PlanContext``.
    scope : bytes
        Key of the map version in indexes.
    created : float
        Time of the plan [s since the epoch].
    waypoints : int
        Number of waypoints.
    index_key : int
        Key of its length and ends in an index (``ppaas.plans.encoding.end_buckets``).
    body : bytes
        Data of this plan alone (``ppaas.plans.encoding.body``).
    codes : list of bytes
        Its shared segments, in order (``ppaas.plans.encoding.codes``).
    shared : int
        Number of waypoints in the shared segments.
    """

    id: str
    map: str
    context: bytes
    scope: bytes
    created: float
    waypoints: int
    index_key: int
    body: bytes
    codes: list[bytes]
    shared: int

    @property
    def unshared(self) -> int:
        """Number of waypoints that are stored for this plan alone."""
        return self.waypoints - self.shared


def entries_of(records: Iterable[PlanRecord], granularity: int) -> Iterator[PlanEntry]:
    """Yield the parts of plans.

    Parameters
    ----------
    records : iterable of PlanRecord
    granularity : int
        Length from which segments are shared, about [waypoints].

    Raises
    ------
    InvalidInput
        A plan is not valid (``storage.plan_checks``).
    """
    left = iter(records)
    while batch := list(itertools.islice(left, _AT_ONCE)):
        yield from _entries(batch, granularity)


def context_of(data: bytes) -> PlanContext:
    """Return the decoded context; the caller may change its parameters, if there are any."""
    common = _decode_cached(data)
    return decode(data, PlanContext) if common.parameters else common


def head_of(context: bytes, own: PlanBody) -> PlanRecord:
    """Return the head of a plan from its context and body."""
    return _record(context_of(context), own, b"")


def record_of(context: bytes, body: bytes, shared: list[Poses]) -> PlanRecord:
    """Return a plan from its parts; ``shared`` are the (n, 7) poses of its shared segments, in order."""
    own = read_body(body)
    return _record(context_of(context), own, own.poses(shared).astype("<f8", copy=False).tobytes())


@lru_cache(1 << 10)
def _decode_cached(data: bytes) -> PlanContext:
    """Return the decoded context; most plans that a search finds have the same one."""
    return decode(data, PlanContext)


def _entries(records: list[PlanRecord], granularity: int) -> Iterator[PlanEntry]:
    poses = check_plans(records)
    contexts = [encode_plain(_context(record)) for record in records]
    counts = [len(record.poses) // POSE_BYTES for record in records]
    words, stops = words_of(poses), np.array(list(itertools.accumulate(counts)), np.int64)
    # Cut all plans at once, and encode the segments; `codes_by_plan` has the segments of each plan.
    cuts = cut_plans(words, stops, granularity)
    codes, first, codes_by_plan = codes_of(poses, cuts.begins, cuts.ends), 0, []
    for stop in cuts.parts.tolist():
        codes_by_plan.append(codes[first:stop])
        first = stop
    shared = cuts.shared.tolist()
    # A plan without shared segments has its waypoints between the ends in its body.
    between = [
        None if is_shared or not each else each[0] for each, is_shared in zip(codes_by_plan, shared, strict=True)
    ]
    bodies, ends = write_bodies([record.id for record in records], list(map(_numbers, records)), words, stops, between)
    # Plans of different versions share nothing, because they have different access rights.
    scopes = [scope_of(record.map, record.version) for record in records]
    index_keys = index_keys_of(scopes, ends, np.array([record.length for record in records], np.float64)).tolist()
    for record, context, scope, count, index_key, body, own, is_shared in zip(
        records, contexts, scopes, counts, index_keys, bodies, codes_by_plan, shared, strict=True
    ):
        yield PlanEntry(
            record.id, record.map, context, scope, record.created, count, index_key, body, own if is_shared else [],
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
