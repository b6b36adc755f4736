"""Reading plans from Cassandra whose ends are near two places: first representatives, then plans of overfull cells."""

import heapq
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans.endpoint_cells import NearbyBuckets, length_of_cell
from storage.cassandra.plans.representatives import OVERFULL

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
