"""Statistics of plans in Cassandra: sums per writer, so that plans need not be counted for each request."""

import threading
import uuid
from collections.abc import Mapping
from typing import Any

from ppaas.clock import Clock, epoch
from storage.cassandra.connection.session import CassandraSession, Write
from storage.encoding import decode_readable, encode
from storage.records import PlanStatistics

IDLE = 12 * 3600.0
"""Time without writes after which a writer starts new sums [s]; sums that are twice as old are final."""

RECOUNTED = uuid.UUID(int=0)
"""Id in place of a writer, for the difference between a count of all plans and the sums of the writers."""

Sums = dict[str, PlanStatistics]
"""Size of the plans of each map, or the change of it, by map id."""

_WRITE = "UPDATE plan_sums USING TIMESTAMP ? SET record = ? WHERE map = ? AND writer = ?"


def add(one: PlanStatistics, other: PlanStatistics, sign: int = 1) -> PlanStatistics:
    """Return the sum of two statistics, or their difference if ``sign`` is -1."""
    return PlanStatistics(
        one.plans + sign * other.plans,
        one.waypoints + sign * other.waypoints,
        one.kept + sign * other.kept,
        one.entries + sign * other.entries,
        one.bytes + sign * other.bytes,
    )


class PlanStatisticsSums:
    """Sums by map and writer. Each write has the total of its writer, so repeated writes change nothing.

    Parameters
    ----------
    session : CassandraSession
    clock : callable
        Seconds since the epoch.
    """

    def __init__(self, session: CassandraSession, clock: Clock = epoch) -> None:
        self._session = session
        self._clock = clock
        self._lock = threading.Lock()
        self._writer = uuid.uuid4()
        self._mine: Sums = {}
        self._written = 0

    def writes_for(self, change: Sums, sign: int = 1) -> list[Write]:
        """Return writes that add a change to the sums, or undo it if ``sign`` is -1."""
        with self._lock:
            now = int(self._clock() * 1e6)
            if now - self._written > IDLE * 1e6:
                self._writer, self._mine = uuid.uuid4(), {}
            self._written = stamp = max(now, self._written + 1)  # increases, so that the later write wins
            for map_id, sums in change.items():
                self._mine[map_id] = add(self._mine.get(map_id, PlanStatistics()), sums, sign)
            return [(_WRITE, (stamp, encode(self._mine[map_id]), map_id, self._writer)) for map_id in change]

    def of(self, map_id: str | None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans."""
        where, values = ("", ()) if map_id is None else (" WHERE map = ?", (map_id,))
        total = PlanStatistics()
        rows = self._session.rows(f"SELECT map, writer, record FROM plan_sums{where}", *values)
        for sums in decode_readable(((row.record, _place(row)) for row in rows), PlanStatistics):
            total = add(total, sums)
        return total if total.plans > 0 else PlanStatistics()

    def by_writer(self) -> dict[tuple[str, uuid.UUID], tuple[PlanStatistics, float]]:
        """Return the sums and the time of their last write [s since the epoch], by map and writer."""
        rows = self._session.rows("SELECT map, writer, record, WRITETIME(record) AS written FROM plan_sums")
        read = ((row, decode_readable([(row.record, _place(row))], PlanStatistics)) for row in rows)
        return {(row.map, row.writer): (sums[0] if sums else PlanStatistics(), row.written / 1e6) for row, sums in read}

    def recount(
        self, counted: Sums, before: Mapping[tuple[str, uuid.UUID], tuple[PlanStatistics, float]], began: float
    ) -> None:
        """Correct the sums by a count of all plans.

        Parameters
        ----------
        counted : dict
            Size of the plans that were written before ``began``, by map.
        before : dict
            The sums at that time (``by_writer``).
        began : float
            Time at which the count began [s since the epoch].
        """
        writers = {key: row for key, row in before.items() if key[1] != RECOUNTED}
        ended = {key for key, (_, written) in writers.items() if began - written > 2.0 * IDLE}
        bases = {
            map_id: counted.get(map_id, PlanStatistics()) for map_id in {*counted, *(map_id for map_id, _ in before)}
        }
        # A base and the sums of active writers add up to the count; the sums of ended writers are deleted.
        for key in writers.keys() - ended:
            bases[key[0]] = add(bases[key[0]], writers[key][0], -1)
        stamp = int(began * 1e6)
        self._session.write_each(_WRITE, [(stamp, encode(sums), map_id, RECOUNTED) for map_id, sums in bases.items()])
        self._session.write_each("DELETE FROM plan_sums WHERE map = ? AND writer = ?", ended)


def _place(row: Any) -> str:
    return f"plan_sums/{row.map}/{row.writer}"
