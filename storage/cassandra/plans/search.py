"""Searching plans in Cassandra by their ends and passages, and their statistics.

Plans whose ends are near two places are read in turns: first representatives, then plans of overfull cells.
"""

import heapq
import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import attrgetter
from typing import Any

from ppaas.plans.encoding.body import bodies_near
from ppaas.plans.encoding.chunks import ENDS_BEFORE
from ppaas.plans.encoding.codes import unpack, waypoints_in
from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.endpoint_cells import NearbyBuckets, length_of_cell, quantized_length
from storage.cassandra.plans.representatives import OVERFULL
from storage.cassandra.plans.rows import head_parts, kept_plans
from storage.cassandra.plans.store import CassandraPlans
from storage.names import check_name
from storage.plan_entry import head_of
from storage.plan_query import PlanStoreQuery
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics

FIRST, NEXT = 256, 1024
"""Representatives that are read of each bucket with the first query, and of one bucket with each further query."""

OVERFULL_CELLS_AT_ONCE = 16
"""Largest number of overfull cells that are read at once."""

MIN_FROM_OVERFULL = 32
"""Smallest number of plans that are read at once from the overfull cells of a bucket."""

_FIRST = "SELECT bucket, spot, id, head FROM plan_fronts WHERE bucket IN ? PER PARTITION LIMIT ?"
_NEXT = "SELECT bucket, spot, id, head FROM plan_fronts WHERE bucket = ? AND (spot, id) > (?, ?) LIMIT ?"
_OVERFULL = "SELECT spot, id, head FROM plans_at_spots WHERE bucket = ? AND spot IN ? LIMIT ?"


class NearbyPlans:
    """Reads the rows of plans that may connect two places, shortest first.

    Two heaps, sorted by cell and so by length, have the work that is left: `_overfull`, cells with more plans than
    representatives, and `_continuations`, where to continue reading the representatives of a bucket.

    Parameters
    ----------
    session : CassandraSession
    buckets : NearbyBuckets
        Buckets near the two places.
    """

    def __init__(self, session: CassandraSession, buckets: NearbyBuckets) -> None:
        self._session = session
        self._buckets = buckets
        self._markers: list[Any] = []
        self._overfull: list[tuple[int, bytes]] = []
        self._continuations: list[tuple[int, bytes, str]] = []
        self._too_few = False

    def first(self) -> list[Any]:
        """Return the shortest representatives of each bucket."""
        return self._plans_in(self._session.rows(_FIRST, self._buckets.ids, FIRST), FIRST)

    def more(self, limit: int, longest: int | None) -> list[Any] | None:
        """Return further plans, of which some may have been returned before; None if there are no more.

        Parameters
        ----------
        limit : int
            Number of plans that the caller wants.
        longest : int, optional
            If the caller has that many, the length of the longest of them (``quantized_length``) [1/16 m].
        """
        self._too_few |= longest is None
        if self._too_few:  # once plans of overfull cells count, shorter ones in other overfull cells count too
            self._queue_overfull_cells()
        reads_overfull = bool(self._overfull) and (
            not self._continuations or self._overfull[0] < self._continuations[0][:2]
        )
        waiting = self._overfull if reads_overfull else self._continuations
        if not waiting or (longest is not None and length_of_cell(waiting[0][0]) >= longest):
            return None
        if reads_overfull:
            return self._from_overfull_cells(max(limit, MIN_FROM_OVERFULL))
        spot, bucket, plan_id = heapq.heappop(self._continuations)
        return self._plans_in(self._session.rows(_NEXT, bucket, spot, plan_id, NEXT), NEXT)

    def _plans_in(self, result: Iterable[Any], limit: int) -> list[Any]:
        """Return the plans among representatives; collect markers, and the buckets that reached the query's limit."""
        rows = list(result)
        for bucket, count in Counter(row.bucket for row in rows).items() if len(rows) >= limit else ():
            if count == limit:
                last = next(row for row in reversed(rows) if row.bucket == bucket)
                heapq.heappush(self._continuations, (last.spot, bucket, last.id))
        self._markers += [row for row in rows if row.id == OVERFULL]
        return [row for row in rows if row.id != OVERFULL]

    def _queue_overfull_cells(self) -> None:
        """Queue the cells of the collected markers; most searches never need them."""
        for bucket, spot in self._buckets.connecting(self._markers):
            heapq.heappush(self._overfull, (spot, bucket))
        self._markers = []

    def _from_overfull_cells(self, limit: int) -> list[Any]:
        """Return plans of the next overfull cells.

        If one cell has ``limit`` plans or more, the rest is skipped: they are alike, with ends within two centimetres.
        """
        spots_by_bucket: dict[bytes, list[int]] = {}
        for _ in range(min(OVERFULL_CELLS_AT_ONCE, len(self._overfull))):
            spot, bucket = heapq.heappop(self._overfull)
            spots_by_bucket.setdefault(bucket, []).append(spot)
        results = {
            bucket: self._session.query_async(_OVERFULL, bucket, spots, limit)
            for bucket, spots in spots_by_bucket.items()
        }
        return [
            row
            for bucket, result in results.items()
            for row in self._read(bucket, spots_by_bucket[bucket], result, limit)
        ]

    def _read(self, bucket: bytes, spots: Sequence[int], result: Callable[[], list[Any]], limit: int) -> list[Any]:
        """Return the rows of a query; cells that its limit did not reach are queued again."""
        rows = result()
        if len(rows) == limit:
            for spot in spots:
                if spot > rows[-1].spot:
                    heapq.heappush(self._overfull, (spot, bucket))
        return rows


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
