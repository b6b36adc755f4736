"""Plans in Cassandra: looked for by where they lead, and told of."""

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
"""Plans that are looked at for whether they pass two places."""

NEWEST = 1024
"""Plans of a map, the newest, among which are counted those that share a stretch."""


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
        """Return the stretches of a plan that are entries of their own, in order; ``NotFound`` if there is none.

        How many plans refer to one is counted among ``NEWEST`` plans of its map, and among all when these are swept.
        """
        kept = self._known_plan(plan_id)
        [numbers] = self._entries.segment_ids([kept.recipe])
        data = self._entries.data(numbers)
        uses = self._uses(self._head(kept).map, numbers)
        first, told = ENDS_BEFORE, []
        for number in numbers:
            count = waypoints_in(unpack(data[number]))
            told.append(PlanPart(number.hex(), first, count, uses[number]))
            first += count
        return told

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return what the plans of a map take, or all; stretches that were shared count until they are swept away."""
        if map_id is not None:
            check_name("map", map_id)
        return self._plan_sums.of(map_id)

    # -- internals -----------------------------------------------------------------------------------------------------

    def _fitting(self, rows: Sequence[Any], search: PlanStoreQuery, limit: int) -> Iterator[PlanRecord]:
        """Yield the heads in rows that are looked for, the shortest so many."""
        parts = [head_parts(row.head) for row in rows]
        contexts = self._entries.data(context for context, _ in parts)
        near = bodies_near([body for _, body in parts], search.start, search.goal, search.tolerance)
        heads = (head_of(contexts[parts[at][0]], own) for at, own in near if search.joins(*own.ends()))
        return itertools.islice(filter(search.matches, heads), limit)

    def _passing(self, search: PlanStoreQuery) -> Iterable[PlanRecord]:
        """Return plans that are named near either place, those that are named near both first."""
        scope, tolerance = search.scope, search.tolerance
        named = [
            self._passage_index.plans_near(scope, place, tolerance, MAX_EXAMINED)
            for place in (search.start, search.goal)
        ]
        both = set(named[0]) & set(named[1])
        ordered = dict.fromkeys([*(one for one in named[0] if one in both), *named[0], *named[1]])
        return self.whole_plans(list(itertools.islice(ordered, MAX_EXAMINED))).values()

    def _uses(self, map_id: str, numbers: list[bytes]) -> dict[bytes, int]:
        """Return how many plans refer to each of some stretches, as far as that is known."""
        wanted = list(dict.fromkeys(numbers))
        swept = self._session.rows_each("SELECT plans FROM plan_entry_uses WHERE id = ?", [(one,) for one in wanted])
        seen: Counter[bytes] = Counter()
        for page in itertools.islice(self._listed(map_id), NEWEST // PAGE):
            kept = kept_plans(self._session, [row.id for row in page])
            for mine in self._entries.segment_ids(each.recipe for each in kept if each is not None):
                seen.update(set(mine).intersection(wanted))
        return {one: max(1, seen[one], *(row.plans for row in rows)) for one, rows in zip(wanted, swept, strict=True)}
