"""Plans in Cassandra: kept, changed and read."""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any

from ppaas.errors import Conflict, NotFound
from storage.cassandra_entries import GRACE, CassandraEntries
from storage.cassandra_plan_rows import PlanRow, bucket_of, plan_rows, with_poses
from storage.cassandra_session import BYTES_TOGETHER, CassandraSession, Write
from storage.cassandra_squares import Squares
from storage.encoding import decode
from storage.names import check_name
from storage.plan_checks import POSE_BYTES, check_plan, check_replacement
from storage.records import PlanRecord

PAGE = 128

LARGE = 32 << 10
"""Bytes of a plan that are too many to be written in one step: Cassandra takes 50 KiB."""

_PLAN = "SELECT head, scope, before, ends, recipe, depth FROM plans WHERE id = ?"
_COLUMNS = "head = ?, scope = ?, before = ?, ends = ?, recipe = ?, depth = ?, count = ?"
_INSERT = "INSERT INTO plans (head, scope, before, ends, recipe, depth, count, id) VALUES (?, ?, ?, ?, ?, ?, ?, ?)"


class CassandraPlans:
    """What a ``PlanStore`` keeps, in Cassandra.

    What a plan refers to is there before it; its row and those by which it is found come together. Of many plans that
    are kept together all are kept, or, where it ends in ``Unavailable``, some: to keep them again changes nothing.
    """

    _session: CassandraSession
    _granularity: int

    @cached_property
    def _entries(self) -> CassandraEntries:
        return CassandraEntries(self._session)

    @cached_property
    def _squares(self) -> Squares:
        return Squares(self._session)

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan; keeping the same id twice changes nothing."""
        self.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans; return how many were not there before."""
        given: dict[str, PlanRecord] = {}
        for record in records:
            given.setdefault(check_plan(record).id, record)
        known = self._known_ids(list(given))
        rows = list(plan_rows([record for record in given.values() if record.id not in known], self._granularity))
        self._keep_beside(rows)
        self._session.write_together_each(_together(rows))
        return len(rows)

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Keep a plan in place of the one of the same id; ``Conflict`` if that was changed meanwhile."""
        check_plan(record)
        kept = self._plan_row(record.id)
        before = None if kept is None else self._whole(kept)
        check_replacement(record, before, instead_of)
        [old, new] = [next(plan_rows([one], self._granularity)) for one in (instead_of, record)]
        self._keep_beside([new])
        change = f"UPDATE plans SET {_COLUMNS} WHERE id = ? IF head = ? AND ends = ? AND recipe = ?"
        if not self._session.write_if(change, *_values(new), record.id, kept.head, kept.ends, kept.recipe):
            raise Conflict(f"the plan {record.id!r} was changed meanwhile: look at it and try again")
        found = _index(new)
        keys = {_key(write) for write in found}
        self._session.write_together([*(one for one in _unindex(old) if _key(one) not in keys), *found])

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        return self._whole(self._known_plan(plan_id))

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        check_name("map", map_id)
        return list(itertools.islice(self._heads(map_id, before), limit))

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted."""
        return self._session.partitions("plans_by_map", "map")

    def remove_plan(self, plan_id: str) -> None:
        """Forget a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        [row] = plan_rows([self._whole(self._known_plan(plan_id))], self._granularity)
        self._session.write_together(_unindex(row))
        self._squares.remove(row)
        if not self._session.write_if("DELETE FROM plans WHERE id = ? IF EXISTS", plan_id):
            raise NotFound("plan", plan_id)

    def remove_plans(self, map_id: str) -> int:
        """Forget the plans of a map, one by one; return how many."""
        removed = 0
        for head in self._heads(check_name("map", map_id), None):
            with suppress(NotFound):  # another removed it
                self.remove_plan(head.id)
                removed += 1
        return removed

    def sweep_entries(self, grace: float = GRACE) -> int:
        """Remove the entries that no plan refers to any more and nobody wrote of late; return how many.

        Parameters
        ----------
        grace : float
            How long an entry is kept after it was written last [s]; longer than any plan takes to be kept.
        """
        referred: set[bytes] = set()
        for row in self._session.rows("SELECT recipe, depth FROM plans"):
            referred |= self._entries.referred(row.recipe, row.depth)
        return self._entries.sweep(referred, grace)

    # -- inside --------------------------------------------------------------------------------------------------------

    def _known_ids(self, plan_ids: Sequence[str]) -> set[str]:
        groups = [(list(plan_ids[at : at + PAGE]),) for at in range(0, len(plan_ids), PAGE)]
        found = self._session.rows_each("SELECT id FROM plans WHERE id IN ?", groups)
        return {row.id for rows in found for row in rows}

    def _keep_beside(self, rows: Sequence[PlanRow]) -> None:
        """Keep what plans refer to, and where they pass."""
        self._entries.keep({number: data for row in rows for number, data in row.entries.items()})
        self._squares.add(rows)

    def _heads(self, map_id: str, before: tuple[float, str] | None) -> Iterator[PlanRecord]:
        query, values = "SELECT created, id FROM plans_by_map WHERE map = ?", tuple[Any, ...]((map_id,))
        if before is not None:
            query, values = f"{query} AND (created, id) < (?, ?)", (map_id, before[0] + 0.0, before[1])
        rows = self._session.rows(query, *values)
        while page := list(itertools.islice(rows, PAGE)):
            heads = self._session.rows_each("SELECT head FROM plans WHERE id = ?", [(row.id,) for row in page])
            for row, found in zip(page, heads, strict=True):
                head = decode(found[0].head, PlanRecord) if found else None
                if head is not None and (head.map, head.created) == (map_id, row.created):  # else it was just changed
                    yield head

    def _plan_row(self, plan_id: str) -> Any:
        return self._session.row(_PLAN, plan_id)

    def _known_plan(self, plan_id: str) -> Any:
        row = self._plan_row(plan_id)
        if row is None:
            raise NotFound("plan", plan_id)
        return row

    def _whole(self, row: Any) -> PlanRecord:
        """Return a plan of its row, with its poses."""
        parts = self._entries.parts(row.recipe, row.depth)
        at = row.before * 56
        poses = row.ends[:at] + self._entries.poses(row.scope, parts) + row.ends[at:]
        return with_poses(decode(row.head, PlanRecord), poses)


def _values(row: PlanRow) -> tuple[Any, ...]:
    count = len(row.record.poses) // POSE_BYTES
    return row.head, row.scope, row.before, row.ends, row.recipe, row.depth, count


def _together(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
    """Yield what keeps plans, some at a time: as many as Cassandra takes without a warning."""
    writes: list[Write] = []
    size = 0
    for row in rows:
        mine = 2 * len(row.head) + len(row.ends) + len(row.recipe)
        parts = [(_INSERT, (*_values(row), row.record.id)), *_index(row)]
        if mine > LARGE:
            yield from ([part] for part in parts)
            continue
        if writes and size + mine > BYTES_TOGETHER:
            yield writes
            writes, size = [], 0
        writes += parts
        size += mine
    if writes:
        yield writes


def _index(row: PlanRow) -> list[Write]:
    """Return what has a plan found by its map and its ends."""
    record, (start, goal) = row.record, row.places
    by_ends = "INSERT INTO plans_by_ends (bucket, length, id, ends, head) VALUES (?, ?, ?, ?, ?)"
    bucket = bucket_of(row.scope, start, goal)
    return [
        ("INSERT INTO plans_by_map (map, created, id) VALUES (?, ?, ?)", (record.map, record.created + 0.0, record.id)),
        (by_ends, (bucket, record.length + 0.0, record.id, [*start, *goal], row.head)),
    ]


def _unindex(row: PlanRow) -> list[Write]:
    """Return what has a plan found no more."""
    record = row.record
    bucket = bucket_of(row.scope, *row.places)
    by_map = "DELETE FROM plans_by_map WHERE map = ? AND created = ? AND id = ?"
    return [
        (by_map, (record.map, record.created + 0.0, record.id)),
        (
            "DELETE FROM plans_by_ends WHERE bucket = ? AND length = ? AND id = ?",
            (bucket, record.length + 0.0, record.id),
        ),
    ]


def _key(write: Write) -> tuple[Any, ...]:
    """Return the key of a row that is written or removed: together, the removal would win."""
    return tuple(write[1][:3])
