"""Plans in Cassandra: kept, changed and read."""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any

from ppaas.errors import Conflict, NotFound, Unavailable
from ppaas.plans.encoding.body import read_body
from ppaas.plans.encoding.codes import pack, poses_of, waypoints_in
from ppaas.plans.encoding.index_cells import scope_of
from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.endpoint_cells import led
from storage.cassandra.plans.entries import CassandraEntries, code_of
from storage.cassandra.plans.lookup import KeptPlan, kept_plans
from storage.cassandra.plans.passage_index import Squares
from storage.cassandra.plans.representatives import Fronts
from storage.cassandra.plans.rows import PlanRow, loose_in, plan_rows
from storage.cassandra.plans.statistics import PlanSums, Sums, added
from storage.cassandra.plans.writes import forgetting, indexing, laying, naming, unlisting
from storage.names import check_name
from storage.plan_checks import check_plan, check_replacement
from storage.plan_entry import context_of, head_of, record_of
from storage.records import PlanRecord, PlanStatistics

_KNOWN = "SELECT id FROM plans WHERE id IN ?"
_CHANGE = "UPDATE plans SET lead = ?, head = ?, recipe = ? WHERE id = ? IF lead = ? AND head = ?"
_REMOVE = "DELETE FROM plans WHERE id = ?"


class CassandraPlans:
    """What a ``PlanStore`` keeps, in Cassandra.

    What a plan refers to, and what names it, is there before it. Of many plans that are kept together all are kept, or,
    where it ends in ``Unavailable``, some: to keep them again changes nothing.
    """

    _session: CassandraSession
    _granularity: int

    @cached_property
    def _entries(self) -> CassandraEntries:
        return CassandraEntries(self._session)

    @cached_property
    def _fronts(self) -> Fronts:
        return Fronts(self._session)

    @cached_property
    def _squares(self) -> Squares:
        return Squares(self._session)

    @cached_property
    def _plan_sums(self) -> PlanSums:
        return PlanSums(self._session)

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan; keeping the same id twice changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans; return how many were not there before."""
        given: dict[str, PlanRecord] = {}
        for record in records:
            given.setdefault(check_name("plan", record.id), record)
        ids = list(given)
        asked = [self._session.asked(_KNOWN, ids[at : at + PAGE]) for at in range(0, len(ids), PAGE)]
        rows = list(plan_rows(list(given.values()), self._granularity))  # most are new: cut them while that is answered
        named = [row.id for answer in asked for row in answer()]
        known = {kept.id for kept in kept_plans(self._session, named) if kept is not None}
        rows = [row for row in rows if row.record.id not in known]
        if rows:
            self._keep(rows)
        return len(rows)

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Keep a plan in place of the one of the same id; ``Conflict`` if that was changed meanwhile."""
        check_plan(record)
        [kept] = kept_plans(self._session, [record.id])
        check_replacement(record, None if kept is None else self._whole(kept), instead_of)
        assert kept is not None
        [row] = plan_rows([record], self._granularity)
        fresh = self._refer([row])
        front = self._fronts.replacing(led(instead_of), row)
        seen = kept.lead, kept.head if kept.replaced else None
        if not self._session.write_if(_CHANGE, row.lead, row.head, row.recipe, record.id, *seen):
            raise Conflict(f"the plan {record.id!r} was changed meanwhile: look at it and try again")
        change = _taken([row], fresh)
        gone = taken_by(kept.body, kept.recipe)
        change[instead_of.map] = added(change.get(instead_of.map, PlanStatistics()), gone, -1)
        beside = [*self._squares.naming([row]), *self._plan_sums.adding(change)]
        self._session.write_all([[*forgetting(instead_of, but=record), *indexing(row), *front]], beside)

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if there is none."""
        return self._whole(self._known_plan(plan_id))

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return those of some plans that are kept, by id."""
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
        """Forget a plan; ``NotFound`` if there is none."""
        kept = self._known_plan(plan_id)
        record = self._whole(kept)
        self._session.write_together([*forgetting(record), *self._fronts.leaving([led(record)])])
        [row] = plan_rows([record], self._granularity)
        self._squares.remove(row)
        if not self._session.write_if(f"{_REMOVE} IF EXISTS", plan_id):
            raise NotFound("plan", plan_id)
        self._session.write_all((), self._plan_sums.adding({record.map: taken_by(kept.body, kept.recipe)}, -1))

    def remove_plans(self, map_id: str) -> int:
        """Forget the plans of a map, a page at a time; return how many."""
        removed = 0
        for page in self._listed(check_name("map", map_id)):
            kept = kept_plans(self._session, [row.id for row in page])
            removed += self._remove_all(map_id, page, [each for each in kept if each is not None])
        return removed

    # -- inside --------------------------------------------------------------------------------------------------------

    def _keep(self, rows: Sequence[PlanRow]) -> None:
        fresh = self._refer(rows)
        front = self._fronts.take(rows, naming(rows))
        change = _taken(rows, fresh)
        beside = [*self._plan_sums.adding(change), *self._squares.naming(rows), *front]
        try:
            self._session.write_apart(laying(rows), beside)
        except Unavailable:
            self._plan_sums.adding(change, -1)
            raise

    def _remove_all(self, map_id: str, page: Sequence[Any], kept: Sequence[KeptPlan]) -> int:
        """Remove plans of a map of a page of its list, and this; return how many."""
        records = [record for record in self._wholes(kept) if record.map == map_id]  # another was changed meanwhile
        mine = {record.id for record in records}
        groups = [[*forgetting(record), (_REMOVE, (record.id,))] for record in records]
        self._squares.clear(plan_rows(records, self._granularity))
        front = self._fronts.leaving(map(led, records))
        self._session.write_all(groups, [*front, *(unlisting(map_id, row) for row in page if row.id not in mine)])
        gone = PlanStatistics()
        for each in kept:
            gone = added(gone, taken_by(each.body, each.recipe)) if each.id in mine else gone
        self._session.write_all((), self._plan_sums.adding({map_id: gone}, -1))
        return len(records)

    def _refer(self, rows: Sequence[PlanRow]) -> set[bytes]:
        """Keep all that plans refer to; return the ids of what was not there before."""
        stretches: dict[bytes, bytes] = {}
        beside: dict[bytes, bytes] = {}
        for row in rows:
            stretches |= row.stretches
            beside |= row.beside
        return self._entries.keep(stretches, pack) | self._entries.keep(beside, bytes)

    def _heads(self, map_id: str, before: tuple[float, str] | None) -> Iterator[PlanRecord]:
        for page in self._listed(map_id, before):
            for row, kept in zip(page, kept_plans(self._session, [row.id for row in page]), strict=True):
                head = self._head(kept) if kept is not None else None
                if head is not None and (head.map, head.created) == (map_id, row.created):  # else it was just changed
                    yield head

    def _listed(self, map_id: str, before: tuple[float, str] | None = None) -> Iterator[list[Any]]:
        """Yield pages of what is listed of a map, newest first."""
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
        """Return a plan with its poses."""
        [whole] = self._wholes([kept])
        return whole

    def _wholes(self, kept: Sequence[KeptPlan]) -> Iterator[PlanRecord]:
        """Yield plans with their poses."""
        recipes = self._entries.stretches(each.recipe for each in kept)
        data = self._entries.data(itertools.chain((each.context for each in kept), *recipes))
        for each, numbers in zip(kept, recipes, strict=True):
            context = data[each.context]
            common = context_of(context)
            scope = scope_of(common.map, common.version)
            yield record_of(context, each.body, [poses_of(code_of(scope, one, data[one])) for one in numbers])


def _taken(rows: Sequence[PlanRow], fresh: set[bytes]) -> Sums:
    """Return what plans and the stretches that are new with them take."""
    sums: Sums = {}
    left = set(fresh)
    for row in rows:
        entry = row.entry
        mine = PlanStatistics(1, entry.waypoints, entry.loose, 0, row.size)
        for number in left & row.stretches.keys() if left else ():
            code = row.stretches[number]
            mine = added(mine, PlanStatistics(0, 0, waypoints_in(code), 1, len(pack(code))))
            left.remove(number)
        sums[entry.map] = added(sums.get(entry.map, PlanStatistics()), mine)
    return sums


def taken_by(body: bytes, recipe: bytes) -> PlanStatistics:
    """Return what a kept plan takes, without what it shares."""
    own = read_body(body)
    return PlanStatistics(1, own.count, loose_in(own), 0, len(body) + len(recipe))
