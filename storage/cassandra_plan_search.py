"""Plans in Cassandra: looked for by where they lead, and told of."""

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from ppaas.errors import NotFound
from ppaas.plans.buckets import Place
from storage.cassandra_plan_rows import Part, buckets_near
from storage.cassandra_plans import PAGE, CassandraPlans
from storage.encoding import decode
from storage.names import check_name
from storage.plan_checks import POSE_BYTES
from storage.plan_search import PlanSearch
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics

FIRST_ROWS = 32
"""Plans of a bucket that are looked at first, the shortest."""

MOST_LOOKED_AT = 64
"""Plans that are looked at for whether they pass two places."""


class CassandraPlanSearch(CassandraPlans):
    """A ``PlanStore`` in Cassandra."""

    def find_plans(
        self,
        map_id: str,
        version: str,
        start: Place,
        goal: Place,
        tolerance: float,
        *,
        planner: str | None = None,
        limit: int = 16,
    ) -> list[PlanRecord]:
        """Return the heads of plans whose ends lie near two places, shortest first."""
        search = PlanSearch(map_id, version, start, goal, tolerance, planner)
        buckets = buckets_near(search.scope, start, goal, tolerance)
        query = "SELECT bucket, length, id, ends, head FROM plans_by_ends WHERE bucket IN ?"
        few = list(self._session.rows(f"{query} PER PARTITION LIMIT ?", buckets, FIRST_ROWS))
        found = self._fitting(few, search)
        if sum(plan.length <= _complete_until(few) for plan in found) < limit and _complete_until(few) < math.inf:
            found = self._fitting(self._session.rows(query, buckets), search)
        return found[:limit]

    def plans_through(
        self,
        map_id: str,
        version: str,
        start: Place,
        goal: Place,
        tolerance: float,
        *,
        planner: str | None = None,
        limit: int = 8,
    ) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, the shortest passage first."""
        search = PlanSearch(map_id, version, start, goal, tolerance, planner)
        return search.passages(self._passing(search), limit)

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the stretches of a plan that are entries of their own, in order; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        row = self._known_plan(plan_id)
        mine = self._entries.parts(row.recipe, row.depth)
        wanted = {part.entry for part in mine}
        shared: Counter[bytes] = Counter()
        for _, parts in self._recipes(decode(row.head, PlanRecord).map):
            shared.update(wanted & {part.entry for part in parts})
        first, told = row.before, []
        for part in mine:
            told.append(PlanPart(part.entry.hex(), first, part.waypoints, max(1, shared[part.entry])))
            first += part.waypoints
        return told

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return what the plans of a map take, or all."""
        if map_id is not None:
            check_name("map", map_id)
        plans = waypoints = kept = size = 0
        entries: dict[bytes, Part] = {}
        for row, parts in self._recipes(map_id):
            plans += 1
            waypoints += row.count
            kept += len(row.ends) // POSE_BYTES
            size += len(row.head) + len(row.ends) + len(row.recipe)
            entries.update((part.entry, part) for part in parts)
        kept += sum(part.waypoints for part in entries.values())
        size += sum(part.size for part in entries.values())
        return PlanStatistics(plans, waypoints, kept, len(entries), size)

    # -- inside --------------------------------------------------------------------------------------------------------

    def _fitting(self, rows: Any, search: PlanSearch) -> list[PlanRecord]:
        """Return the heads in rows of buckets that are looked for, shortest first."""
        near = sorted(
            (row.length, row.id, row.head)
            for row in rows
            if search.joins((row.ends[0], row.ends[1]), (row.ends[2], row.ends[3]))
        )
        return list(filter(search.takes, (decode(head, PlanRecord) for _, _, head in near)))

    def _passing(self, search: PlanSearch) -> Iterator[PlanRecord]:
        """Yield plans that are named near either place, those that are named near both first."""
        scope, tolerance = search.scope, search.tolerance
        named = [self._squares.named(scope, place, tolerance, MOST_LOOKED_AT) for place in (search.start, search.goal)]
        both = set(named[0]) & set(named[1])
        ordered = dict.fromkeys([*(one for one in named[0] if one in both), *named[0], *named[1]])
        for plan_id in list(ordered)[:MOST_LOOKED_AT]:
            try:
                yield self.plan(plan_id)
            except NotFound:
                continue  # removed meanwhile

    def _recipes(self, map_id: str | None) -> Iterator[tuple[Any, list[Part]]]:
        """Yield the rows of the plans of a map, or of all, each with its parts."""
        columns = "head, ends, recipe, depth, count"
        if map_id is None:
            for row in self._session.rows(f"SELECT {columns} FROM plans"):
                yield row, self._entries.parts(row.recipe, row.depth)
            return
        ids = self._session.rows("SELECT id FROM plans_by_map WHERE map = ?", map_id)
        for page in _pages(ids):
            for rows in self._session.rows_each(f"SELECT {columns} FROM plans WHERE id = ?", page):
                if rows:
                    yield rows[0], self._entries.parts(rows[0].recipe, rows[0].depth)


def _pages(rows: Iterator[Any]) -> Iterator[list[tuple[str]]]:
    page: list[tuple[str]] = []
    for row in rows:
        page.append((row.id,))
        if len(page) == PAGE:
            yield page
            page = []
    yield page


def _complete_until(rows: list[Any]) -> float:
    """Return the length up to which no plan of these buckets is missing: where one was cut short, its longest."""
    counts = Counter(row.bucket for row in rows)
    longest = {row.bucket: row.length for row in rows}  # of each bucket they come by length
    return min((longest[bucket] for bucket, count in counts.items() if count == FIRST_ROWS), default=math.inf)
