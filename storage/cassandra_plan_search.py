"""Plans in Cassandra: looked for by where they lead, and told of."""

import itertools
import math
from collections import Counter
from collections.abc import Iterable
from operator import attrgetter
from typing import Any

from ppaas.plans.body import read_bodies
from ppaas.plans.chunks import ENDS_BEFORE
from ppaas.plans.codes import unpack, waypoints_in
from storage.cassandra_plan_rows import buckets_near, reach
from storage.cassandra_plans import CassandraPlans
from storage.cassandra_session import PAGE
from storage.names import check_name
from storage.plan_entry import head_of
from storage.plan_search import PlanSearch
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics

FIRST_ROWS, TIMES_MORE = 32, 16
"""Plans of a bucket that are looked at first, the shortest, and how many times as many next."""

READ_AT_ONCE = 16
"""Plans that are read together, as many as are mostly wanted: to read one costs hardly less."""

MOST_LOOKED_AT = 64
"""Plans that are looked at for whether they pass two places."""

NEWEST = 1024
"""Plans of a map, the newest, among which are counted those that share a stretch."""

_LED = """SELECT bucket, length, id, start_x, start_y, goal_x, goal_y, context, body FROM plans_by_ends
          WHERE bucket IN ? AND start_x >= ? AND start_x <= ? AND start_y >= ? AND start_y <= ?
          AND goal_x >= ? AND goal_x <= ? AND goal_y >= ? AND goal_y <= ? PER PARTITION LIMIT ? ALLOW FILTERING"""
"""The filtering is within the buckets."""


class CassandraPlanSearch(CassandraPlans):
    """A ``PlanStore`` in Cassandra."""

    def find_plans(self, search: PlanSearch, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans whose ends lie near two places, shortest first."""
        buckets = buckets_near(search.scope, search.start, search.goal, search.tolerance)
        sides = itertools.chain.from_iterable(reach(value, search.tolerance) for value in (*search.start, *search.goal))
        values, most = (buckets, *sides), FIRST_ROWS
        while True:
            rows = list(self._session.rows(_LED, *values, most))
            complete = _complete_until(rows, most)
            found = self._fitting(rows, search, limit)
            if complete == math.inf or (len(found) == limit and all(one.length <= complete for one in found)):
                return found
            most *= TIMES_MORE

    def plans_through(self, search: PlanSearch, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, the shortest passage first."""
        return search.passages(self._passing(search), limit)

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the stretches of a plan that are entries of their own, in order; ``NotFound`` if there is none.

        How many plans refer to one is counted among ``NEWEST`` plans of its map, and among all when these are swept.
        """
        row = self._known_plan(plan_id)
        [numbers] = self._entries.stretches([row.recipe])
        data = self._entries.data(numbers)
        uses = self._uses(self._head(row).map, numbers)
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

    # -- inside --------------------------------------------------------------------------------------------------------

    def _fitting(self, rows: list[Any], search: PlanSearch, limit: int) -> list[PlanRecord]:
        """Return the heads in rows of buckets that are looked for, shortest first."""
        ordered = sorted(rows, key=attrgetter("length", "id"))
        near = (row for row in ordered if search.joins((row.start_x, row.start_y), (row.goal_x, row.goal_y)))
        found: list[PlanRecord] = []
        while len(found) < limit and (some := list(itertools.islice(near, READ_AT_ONCE))):
            contexts = self._entries.data(row.context for row in some)
            owns = read_bodies([row.body for row in some])
            heads = (head_of(contexts[row.context], own) for row, own in zip(some, owns, strict=True))
            found += itertools.islice(filter(search.takes, heads), limit - len(found))
        return found

    def _passing(self, search: PlanSearch) -> Iterable[PlanRecord]:
        """Return plans that are named near either place, those that are named near both first."""
        scope, tolerance = search.scope, search.tolerance
        named = [self._squares.named(scope, place, tolerance, MOST_LOOKED_AT) for place in (search.start, search.goal)]
        both = set(named[0]) & set(named[1])
        ordered = dict.fromkeys([*(one for one in named[0] if one in both), *named[0], *named[1]])
        return self.whole_plans(list(itertools.islice(ordered, MOST_LOOKED_AT))).values()

    def _uses(self, map_id: str, numbers: list[bytes]) -> dict[bytes, int]:
        """Return how many plans refer to each of some stretches, as far as that is known."""
        wanted = list(dict.fromkeys(numbers))
        swept = self._session.rows_each("SELECT plans FROM plan_entry_uses WHERE id = ?", [(one,) for one in wanted])
        seen: Counter[bytes] = Counter()
        for page in itertools.islice(self._listed(map_id), NEWEST // PAGE):
            rows = self._session.rows_each("SELECT recipe FROM plans WHERE id = ?", [(row.id,) for row in page])
            for mine in self._entries.stretches(row.recipe for found in rows for row in found):
                seen.update(set(mine).intersection(wanted))
        return {one: max(1, seen[one], *(row.plans for row in rows)) for one, rows in zip(wanted, swept, strict=True)}


def _complete_until(rows: list[Any], most: int) -> float:
    """Return the length up to which no plan of these buckets is missing: where one was cut short, its longest."""
    counts = Counter(row.bucket for row in rows)
    longest = {row.bucket: row.length for row in rows}  # of each bucket they come by length
    return min((longest[bucket] for bucket, count in counts.items() if count == most), default=math.inf)
