"""What a plan must be, so that stores keep it."""

import math
from collections.abc import Sequence

import numpy as np

from ppaas.errors import Conflict, InvalidInput, NotFound
from ppaas.geometry import Poses
from storage.names import check_name
from storage.records import PlanRecord

POSE_BYTES = 56

MOST_WAYPOINTS = 1 << 20
"""Waypoints that a plan may have: 56 MiB. On a map of 8192² cells the longest corridor has more, no way of a robot."""

LONGEST_TEXT = 256
"""Characters that the names of a version and a planner may have."""


def check_plan(record: PlanRecord) -> PlanRecord:
    """Return a plan that stores keep; ``InvalidInput`` as `check_plans`."""
    check_plans([record])
    return record


def check_plans(records: Sequence[PlanRecord]) -> Poses:
    """Return the poses of all plans, one after the other, if stores keep them.

    Raises
    ------
    InvalidInput
        The names of one are no names, its poses no poses, or a number of it is none.
    """
    for record in records:
        check_name("plan", record.id)
        check_name("map", record.map)
        for kind, text in (("user", record.user), ("version", record.version), ("planner", record.planner)):
            if not 0 < len(text) <= LONGEST_TEXT:
                told = f"its {kind} has {len(text)} characters: give 1 to {LONGEST_TEXT}"
                raise InvalidInput(f"plan {record.id!r}: {told}")
        _check_numbers(record)
        _check_size(record)
    poses = array_of(b"".join([record.poses for record in records]))
    # The sum is finite unless a pose is not or they are enormous, and takes a third of the time.
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.add.reduce(poses, axis=None)
    if not math.isfinite(total) and not np.isfinite(poses).all():
        first = next(record for record in records if not np.isfinite(array_of(record.poses)).all())
        raise InvalidInput(f"plan {first.id!r}: a pose is not finite")
    return poses


def array_of(poses: bytes) -> Poses:
    """Return the (n, 7) poses of a record."""
    return np.frombuffer(poses, "<f8").reshape(-1, 7)


def check_replacement(record: PlanRecord, kept: PlanRecord | None, instead_of: PlanRecord) -> None:
    """Raise unless a plan may take the place of what is kept (None where nothing is)."""
    if record.id != instead_of.id:
        raise InvalidInput(f"plan {record.id!r} cannot take the place of {instead_of.id!r}: give one of the same id")
    if kept is None:
        raise NotFound("plan", record.id)
    if kept != instead_of:
        raise Conflict(f"the plan {record.id!r} was changed meanwhile: look at it and try again")


def _check_numbers(record: PlanRecord) -> None:
    finite = (*record.start, *record.goal, record.length, record.seconds, record.created)
    if len(record.start) != 3 or len(record.goal) != 3 or not all(map(math.isfinite, finite)):
        raise InvalidInput(f"plan {record.id!r}: its ends are x, y and yaw, and they, its length and times are finite")
    if min(record.length, record.seconds) < 0.0 or not record.cost >= 0.0:
        raise InvalidInput(f"plan {record.id!r}: its length, cost and time are numbers that are not negative")


def _check_size(record: PlanRecord) -> None:
    count, rest = divmod(len(record.poses), POSE_BYTES)
    if rest or not count:
        raise InvalidInput(f"plan {record.id!r}: {len(record.poses)} bytes are no poses: 7 float64 each, one at least")
    if count > MOST_WAYPOINTS:
        raise InvalidInput(f"plan {record.id!r} has {count} poses, and {MOST_WAYPOINTS} at most are kept")
