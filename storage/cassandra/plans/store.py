"""Adding, replacing, removing and reading plans in Cassandra."""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any

from ppaas.errors import Conflict, NotFound, Unavailable
from ppaas.plans.encoding.body import read_body
from ppaas.plans.encoding.codes import pack, poses_of, waypoints_in
from ppaas.plans.encoding.index_cells import scope_of
from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.endpoint_cells import cell_key
from storage.cassandra.plans.entries import CassandraEntries, code_of
from storage.cassandra.plans.passage_index import PassageIndex
from storage.cassandra.plans.representatives import Representatives
from storage.cassandra.plans.rows import (
    KeptPlan,
    UnwrittenPlan,
    delete_bucket,
    delete_listed,
    index_deletions,
    index_writes,
    insert_names,
    insert_plans,
    kept_plans,
    plan_rows,
    remove_stored,
    unshared_in,
)
from storage.cassandra.plans.statistics import PlanStatisticsSums, Sums, add
from storage.names import check_name
from storage.plan_checks import check_plan, check_replacement
from storage.plan_entry import context_of, head_of, record_of
from storage.records import PlanRecord, PlanStatistics

_KNOWN = "SELECT id FROM plans WHERE id IN ?"
_CHANGE = "UPDATE plans SET lead = ?, head = ?, recipe = ? WHERE id = ? IF lead = ? AND head = ?"
_REMOVE = "DELETE FROM plans WHERE id = ?"


class CassandraPlans:
    """The part of a ``PlanStore`` in Cassandra that is not a search.

    Entries that a plan refers to, and rows that name it, are written before it. If adding several plans ends in
    ``Unavailable``, some of them may be stored; adding them again changes nothing.
    """

    _session: CassandraSession
    _granularity: int

    @cached_property
    def _entries(self) -> CassandraEntries:
        return CassandraEntries(self._session)

    @cached_property
    def _representatives(self) -> Representatives:
        return Representatives(self._session)

    @cached_property
    def _passage_index(self) -> PassageIndex:
        return PassageIndex(self._session)

    @cached_property
    def _plan_sums(self) -> PlanStatisticsSums:
        return PlanStatisticsSums(self._session)

    def add_plan(self, record: PlanRecord) -> None:
        """Add a plan; adding the same id again changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Add plans; return the number of new ones."""
        unique: dict[str, PlanRecord] = {}
        for record in records:
            unique.setdefault(check_name("plan", record.id), record)
        ids = list(unique)
        queries = [self._session.query_async(_KNOWN, ids[at : at + PAGE]) for at in range(0, len(ids), PAGE)]
        rows = list(plan_rows(list(unique.values()), self._granularity))  # most are new: cut them during the queries
        named = [row.id for result in queries for row in result()]
        known = {kept.id for kept in kept_plans(self._session, named) if kept is not None}
        rows = [row for row in rows if row.record.id not in known]
        if rows:
            self._add(rows)
        return len(rows)

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Replace a plan by one of the same id; ``Conflict`` if the stored plan is not ``instead_of``."""
        check_plan(record)
        [kept] = kept_plans(self._session, [record.id])
        check_replacement(record, None if kept is None else self._whole(kept), instead_of)
        assert kept is not None
        [row] = plan_rows([record], self._granularity)
        # Entries first: whatever dies from here on, no plan refers to an entry that is missing.
        fresh = self._write_referenced([row])
        representatives = self._representatives.replacing(cell_key(instead_of), row)
        # The condition names what was read, so of two writers one is refused.
        seen = kept.location, kept.head if kept.replaced else None
        if not self._session.write_if(_CHANGE, row.location, row.head, row.recipe, record.id, *seen):
            raise Conflict(f"plan {record.id!r} has been changed meanwhile: read it again and retry")
        change = _added_statistics([row], fresh)
        removed = own_statistics(kept.body, kept.recipe)
        change[instead_of.map] = add(change.get(instead_of.map, PlanStatistics()), removed, -1)
        beside = [*self._passage_index.additions([row]), *self._plan_sums.writes_for(change)]
        self._session.write_batches(
            [[*index_deletions(instead_of, but=record), *index_writes(row), *representatives]], beside
        )

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if it does not exist."""
        return self._whole(self._known_plan(plan_id))

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return the stored plans among these ids, by id."""
        kept = kept_plans(self._session, [check_name("plan", plan_id) for plan_id in plan_ids])
        return {record.id: record for record in self._wholes([each for each in kept if each is not None])}

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        check_name("map", map_id)
        return list(itertools.islice(self._heads(map_id, before), limit))

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted."""
        named = self._session.partitions("plans_by_map", "map")
        return [map_id for map_id in named if any(self._heads(map_id, None))]

    def remove_plan(self, plan_id: str) -> None:
        """Remove a plan; ``NotFound`` if it does not exist."""
        kept = self._known_plan(plan_id)
        record = self._whole(kept)
        self._session.write_batch([*index_deletions(record), *self._representatives.removing([cell_key(record)])])
        [row] = plan_rows([record], self._granularity)
        self._passage_index.remove(row)
        if not self._session.write_if(f"{_REMOVE} IF EXISTS", plan_id):
            raise NotFound("plan", plan_id)
        self._session.write_batches(
            (), self._plan_sums.writes_for({record.map: own_statistics(kept.body, kept.recipe)}, -1)
        )

    def remove_plans(self, map_id: str) -> int:
        """Remove the plans of a map, page by page; return their number."""
        removed, newest, buckets = 0, None, set[bytes]()
        for page in self._listed(check_name("map", map_id)):
            newest = newest or page[0]
            kept = kept_plans(self._session, [row.id for row in page])
            records = self._remove_all(map_id, [each for each in kept if each is not None])
            self._session.write_unlogged([[delete_listed(map_id, newest, page[-1])]])
            buckets.update(cell_key(record)[0] for record in records)
            removed += len(records)
        # One tombstone a bucket covers those of its plans.
        self._session.write_unlogged((), map(delete_bucket, buckets))
        return removed

    # -- internals -----------------------------------------------------------------------------------------------------

    def _add(self, rows: Sequence[UnwrittenPlan]) -> None:
        fresh = self._write_referenced(rows)
        representatives = self._representatives.choose(rows, insert_names(rows))
        change = _added_statistics(rows, fresh)
        beside = [*self._plan_sums.writes_for(change), *self._passage_index.additions(rows), *representatives]
        try:
            self._session.write_unlogged(insert_plans(rows), beside)
        except Unavailable:
            # The sums are totals of this process, so the next write is right again.
            self._plan_sums.writes_for(change, -1)
            raise

    def _remove_all(self, map_id: str, kept: Sequence[KeptPlan]) -> list[PlanRecord]:
        """Remove plans of a map, but not from its list; return those that are on this map."""
        records = [
            record for record in self._wholes(kept) if record.map == map_id
        ]  # a replacement may be on another map
        mine = {record.id for record in records}
        self._passage_index.clear(plan_rows(records, self._granularity))
        representatives = self._representatives.removing(map(cell_key, records))
        self._session.write_batches(map(remove_stored, records), representatives)
        removed = PlanStatistics()
        for each in kept:
            removed = add(removed, own_statistics(each.body, each.recipe)) if each.id in mine else removed
        self._session.write_batches((), self._plan_sums.writes_for({map_id: removed}, -1))
        return records

    def _write_referenced(self, rows: Sequence[UnwrittenPlan]) -> set[bytes]:
        """Write the entries that plans refer to; return the ids of new ones."""
        segments: dict[bytes, bytes] = {}
        beside: dict[bytes, bytes] = {}
        for row in rows:
            segments |= row.segments
            beside |= row.beside
        return self._entries.add(segments, pack) | self._entries.add(beside, bytes)

    def _heads(self, map_id: str, before: tuple[float, str] | None) -> Iterator[PlanRecord]:
        for page in self._listed(map_id, before):
            for row, kept in zip(page, kept_plans(self._session, [row.id for row in page]), strict=True):
                head = self._head(kept) if kept is not None else None
                if head is not None and (head.map, head.created) == (
                    map_id,
                    row.created,
                ):  # otherwise it has just changed
                    yield head

    def _listed(self, map_id: str, before: tuple[float, str] | None = None) -> Iterator[list[Any]]:
        """Yield pages of the list of a map, newest first."""
        query, values = "SELECT created, id FROM plans_by_map WHERE map = ?", tuple[Any, ...]((map_id,))
        if before is not None:
            query, values = f"{query} AND (created, id) < (?, ?)", (map_id, before[0] + 0.0, before[1])
        rows = self._session.rows(query, *values)
        while page := list(itertools.islice(rows, PAGE)):
            yield page

    def _known_plan(self, plan_id: str) -> KeptPlan:
        [kept] = kept_plans(self._session, [check_name("plan", plan_id)])
        if kept is None:
            raise NotFound("plan", plan_id)
        return kept

    def _head(self, kept: KeptPlan) -> PlanRecord:
        return head_of(self._entries.data((kept.context,))[kept.context], read_body(kept.body))

    def _whole(self, kept: KeptPlan) -> PlanRecord:
        [whole] = self._wholes([kept])
        return whole

    def _wholes(self, kept: Sequence[KeptPlan]) -> Iterator[PlanRecord]:
        recipes = self._entries.segment_ids(each.recipe for each in kept)
        data = self._entries.data(itertools.chain((each.context for each in kept), *recipes))
        for each, numbers in zip(kept, recipes, strict=True):
            context = data[each.context]
            common = context_of(context)
            scope = scope_of(common.map, common.version)
            yield record_of(context, each.body, [poses_of(code_of(scope, one, data[one])) for one in numbers])


def _added_statistics(rows: Sequence[UnwrittenPlan], fresh: set[bytes]) -> Sums:
    sums: Sums = {}
    left = set(fresh)
    for row in rows:
        entry = row.entry
        mine = PlanStatistics(1, entry.waypoints, entry.unshared, 0, row.size)
        for number in left & row.segments.keys() if left else ():
            code = row.segments[number]
            mine = add(mine, PlanStatistics(0, 0, waypoints_in(code), 1, len(pack(code))))
            left.remove(number)
        sums[entry.map] = add(sums.get(entry.map, PlanStatistics()), mine)
    return sums


def own_statistics(body: bytes, recipe: bytes) -> PlanStatistics:
    """Return the statistics of a stored plan without its shared segments."""
    own = read_body(body)
    return PlanStatistics(1, own.count, unshared_in(own), 0, len(body) + len(recipe))
