"""What plans take, in Cassandra: sums that every writer keeps of what it did, so that nobody has to count plans."""

import threading
import uuid
from collections.abc import Mapping

from ppaas.clock import Clock, epoch
from storage.cassandra.connection.session import CassandraSession, Write
from storage.encoding import decode, encode
from storage.records import PlanStatistics

IDLE = 12 * 3600.0
"""Seconds after which a writer begins new sums: those that are older for longer than twice that nobody adds to."""

RECOUNTED = uuid.UUID(int=0)
"""In place of a writer: what a count of all plans found that the sums of writers do not tell."""

Sums = dict[str, PlanStatistics]
"""What the plans of each map take, or what a change adds to that."""

_WRITE = "UPDATE plan_sums USING TIMESTAMP ? SET record = ? WHERE map = ? AND writer = ?"


def add(one: PlanStatistics, other: PlanStatistics, sign: int = 1) -> PlanStatistics:
    """Return what two take together, or ``one`` without the other (-1)."""
    return PlanStatistics(
        one.plans + sign * other.plans,
        one.waypoints + sign * other.waypoints,
        one.kept + sign * other.kept,
        one.entries + sign * other.entries,
        one.bytes + sign * other.bytes,
    )


class PlanStatisticsSums:
    """Sums by map. To write them twice is as if they were written once, since each writer tells all that it ever added.

    Parameters
    ----------
    session : CassandraSession
    clock : callable
        Seconds of the epoch.
    """

    def __init__(self, session: CassandraSession, clock: Clock = epoch) -> None:
        self._session = session
        self._clock = clock
        self._lock = threading.Lock()
        self._writer = uuid.uuid4()
        self._mine: Sums = {}
        self._written = 0

    def writes_for(self, change: Sums, sign: int = 1) -> list[Write]:
        """Return what tells of a change, or that it did not come about (-1)."""
        with self._lock:
            now = int(self._clock() * 1e6)
            if now - self._written > IDLE * 1e6:
                self._writer, self._mine = uuid.uuid4(), {}
            self._written = stamp = max(now, self._written + 1)  # of two writes of this writer the later one counts
            for map_id, sums in change.items():
                self._mine[map_id] = add(self._mine.get(map_id, PlanStatistics()), sums, sign)
            return [(_WRITE, (stamp, encode(self._mine[map_id]), map_id, self._writer)) for map_id in change]

    def of(self, map_id: str | None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans."""
        where, values = ("", ()) if map_id is None else (" WHERE map = ?", (map_id,))
        total = PlanStatistics()
        for row in self._session.rows(f"SELECT record FROM plan_sums{where}", *values):
            total = add(total, decode(row.record, PlanStatistics))
        return total if total.plans > 0 else PlanStatistics()

    def by_writer(self) -> dict[tuple[str, uuid.UUID], tuple[PlanStatistics, float]]:
        """Return by map and writer what is told, and when that was written [s of the epoch]."""
        rows = self._session.rows("SELECT map, writer, record, WRITETIME(record) AS written FROM plan_sums")
        return {(row.map, row.writer): (decode(row.record, PlanStatistics), row.written / 1e6) for row in rows}

    def recount(
        self, counted: Sums, told: Mapping[tuple[str, uuid.UUID], tuple[PlanStatistics, float]], began: float
    ) -> None:
        """Have the sums tell what was counted.

        Parameters
        ----------
        counted : dict
            By map what the plans take that were written before ``began``.
        told : dict
            What was told then.
        began : float
            [s of the epoch]
        """
        writers = {key: row for key, row in told.items() if key[1] != RECOUNTED}
        ended = {key for key, (_, written) in writers.items() if began - written > 2.0 * IDLE}
        bases = {
            map_id: counted.get(map_id, PlanStatistics()) for map_id in {*counted, *(map_id for map_id, _ in told)}
        }
        for key in writers.keys() - ended:
            bases[key[0]] = add(bases[key[0]], writers[key][0], -1)
        stamp = int(began * 1e6)
        self._session.write_each(_WRITE, [(stamp, encode(sums), map_id, RECOUNTED) for map_id, sums in bases.items()])
        self._session.write_each("DELETE FROM plan_sums WHERE map = ? AND writer = ?", ended)
