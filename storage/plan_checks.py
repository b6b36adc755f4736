"""Validation of plans before they are stored."""

import math
from collections.abc import Sequence

import numpy as np

from ppaas.errors import Conflict, InvalidInput, NotFound
from ppaas.geometry import Poses
from storage.names import check_name
from storage.records import PlanRecord

POSE_BYTES = 56

MAX_WAYPOINTS = 1 << 20
"""Largest number of waypoints of a plan (56 MiB). On a map of 8192² cells only an artificial maze has longer paths."""

MAX_TEXT_LENGTH = 256
"""Largest length of a user, a version and a planner [characters]."""


def check_plan(record: PlanRecord) -> PlanRecord:
    """Return the plan if it is valid; raise the errors of `check_plans` otherwise."""
    check_plans([record])
    return record


def check_plans(records: Sequence[PlanRecord]) -> Poses:
    """Return the poses of all plans in one array of shape (n, 7), if the plans are valid.

    Raises
    ------
    InvalidInput
        A plan has a name, poses or numbers that are not valid.
    """
    for record in records:
        check_name("plan", record.id)
        check_name("map", record.map)
        for kind, text in (("user", record.user), ("version", record.version), ("planner", record.planner)):
            if not 0 < len(text) <= MAX_TEXT_LENGTH:
                raise InvalidInput(f"plan {record.id!r}: {kind} has {len(text)} characters: use 1 to {MAX_TEXT_LENGTH}")
        _check_numbers(record)
        _check_size(record)
    poses = array_of(b"".join([record.poses for record in records]))
    # A finite sum proves that all poses are finite, in a third of the time of the exact test below.
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.add.reduce(poses, axis=None)
    if not math.isfinite(total) and not np.isfinite(poses).all():
        first = next(record for record in records if not np.isfinite(array_of(record.poses)).all())
        raise InvalidInput(f"plan {first.id!r}: a pose is not finite")
    return poses


def array_of(poses: bytes) -> Poses:
    """Return the poses of a record as a (n, 7) array."""
    return np.frombuffer(poses, "<f8").reshape(-1, 7)


def check_replacement(record: PlanRecord, kept: PlanRecord | None, instead_of: PlanRecord) -> None:
    """Raise unless a plan may replace the stored one (None if there is none)."""
    if record.id != instead_of.id:
        raise InvalidInput(f"plan {record.id!r} cannot replace plan {instead_of.id!r}: the ids must be equal")
    if kept is None:
        raise NotFound("plan", record.id)
    if kept != instead_of:
        raise Conflict(f"plan {record.id!r} has been changed meanwhile: read it again and retry")


def _check_numbers(record: PlanRecord) -> None:
    finite = (*record.start, *record.goal, record.length, record.seconds, record.created)
    if len(record.start) != 3 or len(record.goal) != 3 or not all(map(math.isfinite, finite)):
        raise InvalidInput(
            f"plan {record.id!r}: start and goal must be x, y and yaw; these, length and times must be finite"
        )
    if min(record.length, record.seconds) < 0.0 or not record.cost >= 0.0:
        raise InvalidInput(f"plan {record.id!r}: length, cost and time must not be negative or NaN")


def _check_size(record: PlanRecord) -> None:
    count, rest = divmod(len(record.poses), POSE_BYTES)
    if rest or not count:
        raise InvalidInput(
            f"plan {record.id!r}: {len(record.poses)} bytes are not poses of 7 float64 each, at least one"
        )
    if count > MAX_WAYPOINTS:
        raise InvalidInput(f"plan {record.id!r} has {count} poses; at most {MAX_WAYPOINTS} are allowed")
