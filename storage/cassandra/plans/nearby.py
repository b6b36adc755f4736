"""Reading plans in Cassandra whose ends lie near two places: those in front, then, where these are few, others."""

import heapq
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans.endpoint_cells import NearbyBuckets, length_of_cell
from storage.cassandra.plans.representatives import OVERFULL

FIRST, NEXT = 256, 1024
"""Rows of a bucket that are read of the front at first, those of the shortest plans, and then at a time."""

OVERFULL_CELLS_AT_ONCE = 16
"""Crowded spots that are looked at together, at most."""

MIN_FROM_OVERFULL = 32
"""Plans of a bucket that are read together at crowded spots, at least."""

_FIRST = "SELECT bucket, spot, id, head FROM plan_fronts WHERE bucket IN ? PER PARTITION LIMIT ?"
_NEXT = "SELECT bucket, spot, id, head FROM plan_fronts WHERE bucket = ? AND (spot, id) > (?, ?) LIMIT ?"
_CROWDED = "SELECT spot, id, head FROM plans_at_spots WHERE bucket = ? AND spot IN ? LIMIT ?"


class NearbyPlans:
    """The rows of plans that may lead from one place to another.

    Parameters
    ----------
    session : CassandraSession
    surroundings : NearbyBuckets
    """

    def __init__(self, session: CassandraSession, surroundings: NearbyBuckets) -> None:
        self._session = session
        self._around = surroundings
        self._told: list[Any] = []
        self._crowds: list[tuple[int, bytes]] = []
        self._behind: list[tuple[int, bytes, str]] = []
        self._too_few = False

    def first(self) -> list[Any]:
        """Return plans in front, the shortest of each bucket."""
        return self._noted(self._session.rows(_FIRST, self._around.buckets, FIRST), FIRST)

    def more(self, limit: int, longest: int | None) -> list[Any] | None:
        """Return plans that were not read before, or some that were; None if there are no more.

        Parameters
        ----------
        limit : int
            How many are sought.
        longest : int, optional
            If as many are found, how long the longest of these is (``quantized_length``).
        """
        self._too_few |= longest is None
        if self._too_few:  # once plans of crowds count, so do shorter ones in others
            self._queue_overfull_cells()
        in_crowds = bool(self._crowds) and (not self._behind or self._crowds[0] < self._behind[0][:2])
        waiting = self._crowds if in_crowds else self._behind
        if not waiting or (longest is not None and length_of_cell(waiting[0][0]) >= longest):
            return None
        if in_crowds:
            return self._from_overfull_cells(max(limit, MIN_FROM_OVERFULL))
        spot, bucket, plan_id = heapq.heappop(self._behind)
        return self._noted(self._session.rows(_NEXT, bucket, spot, plan_id, NEXT), NEXT)

    def _noted(self, answer: Iterable[Any], most: int) -> list[Any]:
        """Return the plans among rows of the front, and note where there are more."""
        rows = list(answer)
        for bucket, count in Counter(row.bucket for row in rows).items() if len(rows) >= most else ():
            if count == most:
                last = next(row for row in reversed(rows) if row.bucket == bucket)
                heapq.heappush(self._behind, (last.spot, bucket, last.id))
        self._told += [row for row in rows if row.id == OVERFULL]
        return [row for row in rows if row.id != OVERFULL]

    def _queue_overfull_cells(self) -> None:
        """Have the crowded spots wait that were told of: mostly nobody asks for them."""
        for bucket, spot in self._around.connecting(self._told):
            heapq.heappush(self._crowds, (spot, bucket))
        self._told = []

    def _from_overfull_cells(self, most: int) -> list[Any]:
        """Return plans at the next crowded spots.

        Of as many plans at one spot some are passed over: they are alike, and their ends two centimetres apart.
        """
        buckets: dict[bytes, list[int]] = {}
        for _ in range(min(OVERFULL_CELLS_AT_ONCE, len(self._crowds))):
            spot, bucket = heapq.heappop(self._crowds)
            buckets.setdefault(bucket, []).append(spot)
        asked = {bucket: self._session.query_async(_CROWDED, bucket, spots, most) for bucket, spots in buckets.items()}
        return [row for bucket, answer in asked.items() for row in self._read(bucket, buckets[bucket], answer, most)]

    def _read(self, bucket: bytes, spots: Sequence[int], answer: Callable[[], list[Any]], most: int) -> list[Any]:
        """Return what is answered of crowded spots; those that it did not come to wait again."""
        rows = answer()
        if len(rows) == most:
            for spot in spots:
                if spot > rows[-1].spot:
                    heapq.heappush(self._crowds, (spot, bucket))
        return rows
