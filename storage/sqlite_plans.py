"""Plans in an SQLite file."""

import math
from collections.abc import Iterable

from ppaas.errors import NotFound
from storage.encoding import decode, encode
from storage.names import check_name
from storage.plan_checks import check_plan, check_replacement
from storage.plan_scan import ScannedPlans
from storage.records import PlanRecord
from storage.sqlite_connections import SqliteConnections
from storage.versions import without_poses


class SqlitePlans(ScannedPlans):
    """A ``PlanStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        To the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._plan_connections = connections

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan; keeping the same id twice changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans, all or none; return how many were not there before."""
        rows = [(record.id, record.map, record.created, encode(check_plan(record))) for record in records]
        insert = "INSERT INTO plans (id, map, created, record) VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING"
        with self._plan_connections.writing() as connection:
            return connection.executemany(insert, rows).rowcount

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Keep a plan in place of the one of the same id; ``Conflict`` if that was changed meanwhile."""
        data = encode(check_plan(record))
        with self._plan_connections.writing() as connection:
            row = connection.execute("SELECT record FROM plans WHERE id = ?", (record.id,)).fetchone()
            check_replacement(record, None if row is None else decode(row[0], PlanRecord), instead_of)
            change = "UPDATE plans SET map = ?, created = ?, record = ? WHERE id = ?"
            connection.execute(change, (record.map, record.created, data, record.id))

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        with self._plan_connections.reading() as connection:
            row = connection.execute("SELECT record FROM plans WHERE id = ?", (plan_id,)).fetchone()
        if row is None:
            raise NotFound("plan", plan_id)
        return decode(row[0], PlanRecord)

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        check_name("map", map_id)
        query = """SELECT record FROM plans WHERE map = ? AND (created, id) < (?, ?)
                   ORDER BY created DESC, id DESC LIMIT ?"""
        with self._plan_connections.reading() as connection:
            # One after the other, so that never more than one has its poses in memory.
            rows = connection.execute(query, (map_id, *(before or (math.inf, "")), -1 if limit is None else limit))
            return [without_poses(decode(row[0], PlanRecord)) for row in rows]

    def remove_plan(self, plan_id: str) -> None:
        """Forget a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        with self._plan_connections.writing() as connection:
            if not connection.execute("DELETE FROM plans WHERE id = ?", (plan_id,)).rowcount:
                raise NotFound("plan", plan_id)

    def _of(self, map_id: str | None, version: str | None = None, planner: str | None = None) -> list[PlanRecord]:
        with self._plan_connections.reading() as connection:
            rows = connection.execute("SELECT record FROM plans WHERE map = coalesce(?, map)", (map_id,))
            plans = (decode(row[0], PlanRecord) for row in rows)
            return [p for p in plans if version in (None, p.version) and planner in (None, p.planner)]
