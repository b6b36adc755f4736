"""Kinds of data that expire: for how long each is kept, and how the expired part is found and removed."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import takewhile
from typing import NamedTuple, Protocol

from engine.control.tasks.group import KEPT_FOR, obsolete
from ppaas.tasks.records import Task
from storage.migration.copying import one_by_one
from storage.people import BEFORE_ALL, HOUR, PeopleCount
from storage.ports import Store
from storage.recordings import RecordingsFolder

DAY = 86400.0

READ_AT_ONCE = 128
"""Records that are read from a store at once."""


class ExpiringLog(Protocol):
    """Audit log from which old events can be removed."""

    def expire(self, before: float, *, dry_run: bool = False) -> int:
        """Remove the events before a time [s since the epoch]; return their number. Blocks."""
        ...


@dataclass(frozen=True, slots=True)
class Kept:
    """Where the data of a cloud are."""

    store: Store
    audit: ExpiringLog
    recordings: RecordingsFolder | None


class Expiry(NamedTuple):
    """Expiry of a kind: data before a time [s since the epoch], at a time; ``dry_run`` removes nothing.

    ``most`` is the size that the rest may have [bytes], for the kinds in `SIZED`.
    """

    before: float
    now: float
    dry_run: bool
    most: float = math.inf


class RetentionKind(NamedTuple):
    """A kind of data.

    Parameters
    ----------
    text : str
        What is removed, and by which time its age is measured.
    expire : callable
        Removes what has expired; returns the number. Blocks.
    """

    text: str
    expire: Callable[[Kept, Expiry], int]


def _recordings(kept: Kept, expiry: Expiry) -> int:
    if kept.recordings is None:
        return 0
    return kept.recordings.expire(expiry.before, most=expiry.most, now=expiry.now, dry_run=expiry.dry_run)


def _audit(kept: Kept, expiry: Expiry) -> int:
    return kept.audit.expire(expiry.before, dry_run=expiry.dry_run)


def _people(kept: Kept, expiry: Expiry) -> int:
    hour, removed = int(expiry.before // HOUR * HOUR), 0
    for map_id in kept.store.people_maps():
        for people in kept.store.people_of_map(map_id):
            found = sum(1 for _ in takewhile(lambda count: count.hour < hour, _counts(kept.store, *people.key)))
            removed += found
            if found and not expiry.dry_run:
                kept.store.remove_people_counts(*people.key, before=hour)
    return removed


def _counts(store: Store, user: str, map_id: str) -> Iterator[PeopleCount]:
    return one_by_one(
        lambda last: store.people_counts(user, map_id, after=last, limit=READ_AT_ONCE),
        BEFORE_ALL,
        lambda count: (count.hour, count.zone),
    )


def _plans(kept: Kept, expiry: Expiry) -> int:
    removed = 0
    for map_id in kept.store.plan_maps():
        before: tuple[float, str] = (expiry.before, "")
        while page := kept.store.plans(map_id, before=before, limit=READ_AT_ONCE):
            before = page[-1].created, page[-1].id
            removed += len(page)
            for plan in page if not expiry.dry_run else ():
                kept.store.remove_plan(plan.id)
    return removed


def _tasks(kept: Kept, expiry: Expiry) -> int:
    removed = 0
    for user, map_id in kept.store.task_groups():
        tasks: list[Task] = [record.task for record in kept.store.tasks(user, map_id)]
        names = obsolete(tasks, expiry.now, expiry.now - expiry.before)
        removed += len(names)
        for name in names if not expiry.dry_run else ():
            kept.store.remove_task(user, map_id, name)
    return removed


def _webhooks(kept: Kept, expiry: Expiry) -> int:
    removed = 0
    for user in kept.store.webhook_users():
        for hook in kept.store.webhooks(user):
            dead = [one for one in kept.store.deliveries(*hook.key) if one.state == "dead"]
            names = [one.id for one in dead if (one.ended or one.created) < expiry.before]
            removed += len(names)
            for name in names if not expiry.dry_run else ():
                kept.store.remove_delivery(*hook.key, name)
    return removed


KINDS: Mapping[str, RetentionKind] = {
    "recordings": RetentionKind(
        "recordings of robots, and the last minutes of robots that are recorded no more, by their last write",
        _recordings,
    ),
    "audit": RetentionKind("events of the audit log, except the last one", _audit),
    "people": RetentionKind("counts of people, by their hour", _people),
    "plans": RetentionKind("plans of the path plan database, by their creation", _plans),
    "tasks": RetentionKind("tasks that have ended, by their end", _tasks),
    "webhooks": RetentionKind("deliveries of webhooks that were given up, by that time", _webhooks),
}
"""All kinds, by the name that settings have."""

SIZED = ("recordings",)
"""Kinds whose size can be limited: beyond it, the oldest are removed."""

DEFAULT_DAYS: Mapping[str, float] = {"tasks": KEPT_FOR / DAY, "webhooks": 30.0}
"""Days for which kinds are kept without a setting; others are kept however old they are."""
