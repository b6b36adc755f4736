"""Searching plans in Cassandra by their ends and passages, and their statistics."""

import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter
from typing import Any

from ppaas.plans.encoding.body import bodies_near
from ppaas.plans.encoding.chunks import ENDS_BEFORE
from ppaas.plans.encoding.codes import unpack, waypoints_in
from storage.cassandra.connection.session import PAGE
from storage.cassandra.plans.endpoint_cells import NearbyBuckets, quantized_length
from storage.cassandra.plans.lookup import kept_plans
from storage.cassandra.plans.nearby import NearbyPlans
from storage.cassandra.plans.rows import head_parts
from storage.cassandra.plans.store import CassandraPlans
from storage.names import check_name
from storage.plan_entry import head_of
from storage.plan_query import PlanStoreQuery
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics

MAX_EXAMINED = 64
"""Largest number of plans that a search for passages examines."""

NEWEST = 1024
"""Number of a map's newest plans among which references to a segment are counted."""


class CassandraPlanSearch(CassandraPlans):
    """A ``PlanStore`` in Cassandra."""

    def find_plans(self, search: PlanStoreQuery, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans that begin and end near two places, shortest first."""
        if limit < 1:
            return []
        near, found = NearbyPlans(self._session, NearbyBuckets(search)), list[PlanRecord]()
        rows: list[Any] | None = near.first()
        while rows is not None:
            known = {head.id for head in found}
            fresh = (head for head in self._fitting(rows, search, limit) if head.id not in known)
            found = sorted((*found, *fresh), key=attrgetter("length", "id"))[:limit]
            rows = near.more(limit, quantized_length(found[-1].length) if len(found) == limit else None)
        return found

    def plans_through(self, search: PlanStoreQuery, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, shortest passage first."""
        return search.passages(self._passing(search), limit)

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the shared segments of a plan, in order; ``NotFound`` if the plan does not exist.

        References to a segment are counted among the ``NEWEST`` plans of its map; the sweep counts them among all.
        """
        kept = self._known_plan(plan_id)
        [numbers] = self._entries.segment_ids([kept.recipe])
        data = self._entries.data(numbers)
        uses = self._uses(self._head(kept).map, numbers)
        first, parts = ENDS_BEFORE, []
        for number in numbers:
            count = waypoints_in(unpack(data[number]))
            parts.append(PlanPart(number.hex(), first, count, uses[number]))
            first += count
        return parts

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans; unused segments count until they are swept."""
        if map_id is not None:
            check_name("map", map_id)
        return self._plan_sums.of(map_id)

    # -- internals -----------------------------------------------------------------------------------------------------

    def _fitting(self, rows: Sequence[Any], search: PlanStoreQuery, limit: int) -> Iterator[PlanRecord]:
        """Yield the heads of the first ``limit`` plans in rows that match the query."""
        parts = [head_parts(row.head) for row in rows]
        contexts = self._entries.data(context for context, _ in parts)
        near = bodies_near([body for _, body in parts], search.start, search.goal, search.tolerance)
        heads = (head_of(contexts[parts[at][0]], own) for at, own in near if search.joins(*own.ends()))
        return itertools.islice(filter(search.matches, heads), limit)

    def _passing(self, search: PlanStoreQuery) -> Iterable[PlanRecord]:
        """Return plans that the passage index has near either place, first those near both."""
        scope, tolerance = search.scope, search.tolerance
        near = [
            self._passage_index.plans_near(scope, place, tolerance, MAX_EXAMINED)
            for place in (search.start, search.goal)
        ]
        both = set(near[0]) & set(near[1])
        ordered = dict.fromkeys([*(one for one in near[0] if one in both), *near[0], *near[1]])
        return self.whole_plans(list(itertools.islice(ordered, MAX_EXAMINED))).values()

    def _uses(self, map_id: str, numbers: list[bytes]) -> dict[bytes, int]:
        """Return the known number of plans that refer to each segment."""
        wanted = list(dict.fromkeys(numbers))
        swept = self._session.rows_each("SELECT plans FROM plan_entry_uses WHERE id = ?", [(one,) for one in wanted])
        seen: Counter[bytes] = Counter()
        for page in itertools.islice(self._listed(map_id), NEWEST // PAGE):
            kept = kept_plans(self._session, [row.id for row in page])
            for mine in self._entries.segment_ids(each.recipe for each in kept if each is not None):
                seen.update(set(mine).intersection(wanted))
        return {one: max(1, seen[one], *(row.plans for row in rows)) for one, rows in zip(wanted, swept, strict=True)}
