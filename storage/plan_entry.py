"""A plan as stores keep it: what many plans have in common, what is its own, and the stretches that it shares."""

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from ppaas.geometry import Poses
from ppaas.plans.body import Body, places_of_ends, read_body, write_body
from ppaas.plans.buckets import scope_of, spot_of
from ppaas.plans.chunks import ENDS_AFTER, ENDS_BEFORE, chunk_bounds
from ppaas.plans.codes import codes_of
from storage.encoding import decode, encode
from storage.plan_checks import POSE_BYTES, array_of, check_plan
from storage.records import PlanOrigin, PlanRecord

_AT_ONCE = 128
"""Plans that are cut together: so many that numpy pays, and so few that they stay in the cache."""


class PlanContext(msgspec.Struct, frozen=True, array_like=True):
    """What many plans have in common."""

    user: str
    map: str
    version: str
    planner: str
    robot: str | None
    origin: PlanOrigin
    parameters: dict[str, Any]


@dataclass(frozen=True, slots=True)
class PlanEntry:
    """What is kept of a plan.

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
        Where it is looked for (``ppaas.plans.buckets``).
    body : bytes
        What is its own (``ppaas.plans.body``).
    codes : list of bytes
        The stretches that it shares, in their order (``ppaas.plans.codes``).
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
    """Return what was encoded; its dictionary is the caller's own."""
    return decode(data, PlanContext)


def head_of(context: bytes, own: Body) -> PlanRecord:
    """Return the head of a plan."""
    return _record(context_of(context), own, b"")


def record_of(context: bytes, body: bytes, shared: list[Poses]) -> PlanRecord:
    """Return a plan, of the stretches that it shares."""
    own = read_body(body)
    return _record(context_of(context), own, own.poses(shared).astype("<f8", copy=False).tobytes())


def _entries(records: list[PlanRecord], granularity: int) -> Iterator[PlanEntry]:
    contexts = [encode(_context(check_plan(record))) for record in records]
    poses = array_of(b"".join([record.poses for record in records]))
    stops = np.cumsum([len(record.poses) // POSE_BYTES for record in records])
    bounds = chunk_bounds(poses, stops, granularity)
    ranges = [_ranges(bound, begin, stop) for bound, begin, stop in zip(bounds, _begins(stops), stops, strict=True)]
    begins, ends = (np.concatenate([side[i] for side in ranges]).astype(np.int64) for i in (0, 1))
    codes = iter(codes_of(poses, begins, ends))
    mine = [list(itertools.islice(codes, len(begin))) for begin, _ in ranges]
    tips = poses[places_of_ends(stops)].tolist()
    for record, context, bound, stretches, ends in zip(records, contexts, bounds, mine, tips, strict=True):
        shared, count = len(bound) > 0, len(record.poses) // POSE_BYTES
        between = stretches[0] if stretches and not shared else None
        body = write_body(record.id, count, _numbers(record), ends, between)
        scope, (first, _, last) = scope_of(record.map, record.version), ends
        spot = spot_of(scope, (first[0], first[1]), (last[0], last[1]), record.length)
        yield PlanEntry(
            record.id, record.map, context, scope, record.created, count, spot, body,
            stretches if shared else [], count - ENDS_BEFORE - ENDS_AFTER if shared else 0,
        )  # fmt: skip


def _context(record: PlanRecord) -> PlanContext:
    return PlanContext(
        record.user, record.map, record.version, record.planner, record.robot, record.origin, record.parameters
    )


def _numbers(record: PlanRecord) -> tuple[float, ...]:
    return (record.created, record.length, record.cost, record.seconds, *record.start, *record.goal)


def _begins(stops: "np.ndarray[Any, np.dtype[np.int64]]") -> list[int]:
    return [0, *stops[:-1].tolist()]


def _ranges(bounds: Any, begin: int, stop: int) -> tuple[Any, Any]:
    """Return where the stretches of a plan begin and end: its entries, or else all between its ends."""
    if len(bounds):
        return bounds[:-1], bounds[1:]
    first, last = begin + ENDS_BEFORE, stop - ENDS_AFTER
    return ([first], [last]) if last > first else ([], [])


def _record(common: PlanContext, own: Body, poses: bytes) -> PlanRecord:
    created, length, cost, seconds, *ends = own.numbers()
    return PlanRecord(
        id=own.plan_id, user=common.user, map=common.map, version=common.version, planner=common.planner,
        start=(ends[0], ends[1], ends[2]), goal=(ends[3], ends[4], ends[5]), length=length, cost=cost, seconds=seconds,
        poses=poses, created=created, robot=common.robot, parameters=common.parameters, origin=common.origin,
    )  # fmt: skip
