"""The path plan database in memory."""

import itertools
import math
import threading
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from ppaas.errors import NotFound
from ppaas.plans.encoding.body import read_body
from ppaas.plans.encoding.chunks import ENDS_BEFORE
from ppaas.plans.encoding.codes import entry_id, poses_of, waypoints_in
from ppaas.plans.encoding.end_buckets import bucket_of_key, buckets_near, cell_number, holds, length_of_key
from ppaas.plans.encoding.granularity import GRANULARITY, inner_granularity
from ppaas.plans.encoding.index_cells import Position, cells_near, cells_touched
from ppaas.plans.passages import comes_near
from storage.names import check_name
from storage.plan_checks import check_replacement
from storage.plan_entry import PlanEntry, entries_of, head_of, record_of
from storage.plan_query import PlanStoreQuery
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics

MAX_PLANS = 32
"""Largest number of plans with a shared segment near each of two places that are examined for passages."""


@dataclass(slots=True)
class _Shared:
    """A shared segment: its code, and how often each plan refers to it."""

    code: bytes
    plans: Counter[str] = field(default_factory=Counter)


class MemoryPlans:
    """A ``PlanStore`` of dictionaries.

    Parameters
    ----------
    granularity : int
        Length from which segments of plans are shared, about [waypoints]; the paper's granularity.
    """

    def __init__(self, granularity: int = GRANULARITY) -> None:
        self._granularity = inner_granularity(granularity)
        self._plans_lock = threading.Lock()
        self._plans: dict[str, PlanEntry] = {}
        self._shared: dict[bytes, _Shared] = {}
        self._by_bucket: dict[int, dict[str, int]] = {}
        self._by_place: dict[int, set[bytes]] = {}

    def add_plan(self, record: PlanRecord) -> None:
        """Add a plan; adding the same id again changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Add plans, all or none; return the number of new ones."""
        entries = list(entries_of(records, self._granularity))
        with self._plans_lock:
            return sum(self._add(entry) for entry in entries)

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Replace a plan by one of the same id; ``Conflict`` if the stored plan is not ``instead_of``."""
        [entry] = entries_of([record], self._granularity)
        with self._plans_lock:
            kept = self._plans.get(record.id)
            check_replacement(record, None if kept is None else self._whole(kept), instead_of)
            self._remove(record.id)
            self._add(entry)

    def remove_plan(self, plan_id: str) -> None:
        """Remove a plan; ``NotFound`` if it does not exist."""
        check_name("plan", plan_id)
        with self._plans_lock:
            self._existing(plan_id)
            self._remove(plan_id)

    def remove_plans(self, map_id: str) -> int:
        """Remove the plans of a map; return their number."""
        check_name("map", map_id)
        with self._plans_lock:
            ids = [entry.id for entry in self._plans.values() if entry.map == map_id]
            for plan_id in ids:
                self._remove(plan_id)
        return len(ids)

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if it does not exist."""
        check_name("plan", plan_id)
        with self._plans_lock:
            return self._whole(self._existing(plan_id))

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return the stored plans among these ids, by id."""
        wanted = [check_name("plan", plan_id) for plan_id in plan_ids]
        with self._plans_lock:
            return {plan_id: self._whole(self._plans[plan_id]) for plan_id in wanted if plan_id in self._plans}

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        check_name("map", map_id)
        key = before or (math.inf, "")
        with self._plans_lock:
            older = [entry for entry in self._plans.values() if entry.map == map_id and (entry.created, entry.id) < key]
        newest = sorted(older, key=lambda entry: (entry.created, entry.id), reverse=True)[:limit]
        return [head_of(entry.context, read_body(entry.body)) for entry in newest]

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted."""
        with self._plans_lock:
            return sorted({entry.map for entry in self._plans.values()})

    def find_plans(self, search: PlanStoreQuery, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans that begin and end near two places, shortest first."""
        with self._plans_lock:
            near = [
                (length_of_key(index_key), self._plans[plan_id])
                for bucket in buckets_near(search.scope, search.start, search.goal, search.tolerance).tolist()
                for plan_id, index_key in self._by_bucket.get(bucket_of_key(bucket[0]), {}).items()
                if holds(bucket, index_key)
            ]
        found: list[PlanRecord] = []
        for _, entry in sorted(near, key=lambda each: each[0]):
            if len(found) >= limit:
                break
            own = read_body(entry.body)
            head = head_of(entry.context, own)
            if search.matches(head):
                found += [head] * search.joins(*own.ends())
        return sorted(found, key=lambda head: (head.length, head.id))

    def plans_through(self, search: PlanStoreQuery, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, shortest passage first."""
        with self._plans_lock:
            near = [self._passing(search.scope, place, search.tolerance) for place in (search.start, search.goal)]
            both = itertools.islice(sorted(near[0] & near[1]), MAX_PLANS)
            records = [self._whole(self._plans[plan_id]) for plan_id in both]
        return search.passages(records, limit)

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the shared segments of a plan, in order; ``NotFound`` if the plan does not exist."""
        check_name("plan", plan_id)
        parts, first = [], ENDS_BEFORE
        with self._plans_lock:
            for key in _keys(self._existing(plan_id)):
                shared = self._shared[key]
                count = waypoints_in(shared.code)
                parts.append(PlanPart(key.hex(), first, count, shared.plans.total()))
                first += count
        return parts

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans."""
        if map_id is not None:
            check_name("map", map_id)
        with self._plans_lock:
            mine = [entry for entry in self._plans.values() if map_id in (None, entry.map)]
            codes = [self._shared[key].code for key in {key for entry in mine for key in _keys(entry)}]
        return PlanStatistics(
            plans=len(mine),
            waypoints=sum(entry.waypoints for entry in mine),
            kept=sum(entry.unshared for entry in mine) + sum(map(waypoints_in, codes)),
            entries=len(codes),
            bytes=sum(len(entry.context) + len(entry.body) for entry in mine) + sum(map(len, codes)),
        )

    # -- internals, with the lock held ---------------------------------------------------------------------------------

    def _existing(self, plan_id: str) -> PlanEntry:
        if plan_id not in self._plans:
            raise NotFound("plan", plan_id)
        return self._plans[plan_id]

    def _whole(self, entry: PlanEntry) -> PlanRecord:
        shared = [poses_of(self._shared[key].code) for key in _keys(entry)]
        return record_of(entry.context, entry.body, shared)

    def _add(self, entry: PlanEntry) -> bool:
        if entry.id in self._plans:
            return False
        for key, code in zip(_keys(entry), entry.codes, strict=True):
            if key not in self._shared:
                self._shared[key] = _Shared(code)
                for cell in cells_touched(poses_of(code)[:, :2]):
                    self._by_place.setdefault(cell_number(entry.scope, cell), set()).add(key)
            self._shared[key].plans[entry.id] += 1
        self._plans[entry.id] = entry
        self._by_bucket.setdefault(bucket_of_key(entry.index_key), {})[entry.id] = entry.index_key
        return True

    def _remove(self, plan_id: str) -> None:
        entry = self._plans.pop(plan_id)
        del self._by_bucket[bucket_of_key(entry.index_key)][plan_id]
        for key in set(_keys(entry)):
            shared = self._shared[key]
            del shared.plans[plan_id]
            if not shared.plans:
                del self._shared[key]
                for cell in cells_touched(poses_of(shared.code)[:, :2]):
                    self._by_place[cell_number(entry.scope, cell)].discard(key)

    def _passing(self, scope: bytes, place: Position, tolerance: float) -> set[str]:
        found: set[str] = set()
        for cell in cells_near(place, tolerance):
            for key in self._by_place.get(cell_number(scope, cell), ()):
                if comes_near(poses_of(self._shared[key].code)[:, :2], place, tolerance):
                    found.update(self._shared[key].plans)
        return found


def _keys(entry: PlanEntry) -> Iterator[bytes]:
    for code in entry.codes:
        yield entry_id(entry.scope, code)
