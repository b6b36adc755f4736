"""The path plan database in an SQLite file; ``storage.sqlite.plan_schema`` describes its tables."""

import itertools
import logging
import math
import sqlite3
import struct
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from ppaas.errors import NotFound, Unavailable
from ppaas.plans.encoding.chunks import ENDS_BEFORE
from ppaas.plans.encoding.codes import entry_id, poses_in, unpack
from ppaas.plans.encoding.end_buckets import cell_number
from ppaas.plans.encoding.index_cells import Position, cells_near, scope_of
from ppaas.plans.encoding.recipes import numbers_in, read_recipe
from ppaas.plans.passages import comes_near
from storage.names import check_name
from storage.plan_checks import check_replacement
from storage.plan_entry import PlanEntry, context_of, entries_of, head_of, record_of
from storage.plan_query import PlanStoreQuery
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics
from storage.sqlite.connections import SqliteConnections
from storage.sqlite.group_commit import GroupCommit
from storage.sqlite.plan_counts import counted_up_to, remove_span, rows_of, uncounted
from storage.sqlite.plan_rows import COLUMNS, PlanRow, plan_faults, plans_between, readable, readable_rows
from storage.sqlite.plan_schema import SPAN
from storage.sqlite.plan_segments import intact_segments, is_intact, segment_faults
from storage.sqlite.plan_writes import IdCache, PlanTransaction, sequence_of, sequences_of
from storage.store_errors import damaged

logger = logging.getLogger(__name__)

MAX_CHUNKS, MAX_PLANS = 256, 32
"""Largest number of entries of a cell of the map, and of plans, that a search for passages examines."""

_WHOLES = f"""SELECT {COLUMNS} FROM {{given}} AS sought JOIN plans ON sequence = sought.id
    JOIN contexts ON contexts.id = context"""
_PLAN = f"SELECT {COLUMNS} FROM plans JOIN contexts ON contexts.id = context WHERE sequence = ?"


class PlanTables:
    """The methods of ``SqlitePlans``, on the tables of the file.

    An acknowledged plan is on the disk. Plans that several threads add at the same time share a transaction.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    granularity : int
        Granularity to cut plans with (``inner_granularity``) [waypoints].
    """

    def __init__(self, connections: SqliteConnections, granularity: int) -> None:
        self._connections = connections
        self._granularity = granularity
        self._id_cache = IdCache()
        self._adding: GroupCommit[list[PlanRecord], int] = GroupCommit(self._add_all)

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Add plans, all or none; return the number of new ones."""
        return self._adding.submit(list(records))

    def _add_all(self, given: Sequence[list[PlanRecord]]) -> list[int | Exception]:
        """Add the plans of several callers in one transaction; return the number of new ones or the error of each."""
        # Plans are cut here, not by each caller: cutting many at once takes little more time than one, and threads
        # that compute compete for the interpreter lock.
        cut = self._cut_all(given)
        valid = [entries for entries in cut if not isinstance(entries, Exception)]
        added = iter(self._add_entries(valid) if valid else ())
        return [entries if isinstance(entries, Exception) else next(added) for entries in cut]

    def _add_entries(self, given: Sequence[list[PlanEntry]]) -> list[int]:
        with self._connections.writing() as connection:
            transaction = PlanTransaction(connection, self._id_cache)
            added = transaction.add(*given)
        transaction.committed()
        return added

    def _cut_all(self, given: Sequence[list[PlanRecord]]) -> list[list[PlanEntry] | Exception]:
        """Return the entries of each caller's plans, or the error of a caller whose plans are not valid."""
        entries = entries_of(itertools.chain.from_iterable(given), self._granularity)
        try:
            return [list(itertools.islice(entries, len(some))) for some in given]
        except Exception as error:  # noqa: BLE001  # returned to the caller at fault alone
            return [error] if len(given) == 1 else [each for some in given for each in self._cut_all([some])]

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Replace a plan by one of the same id; ``Conflict`` if the stored plan is not ``instead_of``."""
        entries = list(entries_of([record], self._granularity))
        with self._connections.writing() as connection:
            sequence = sequence_of(connection, record.id)
            check_replacement(record, None if sequence is None else _whole(connection, sequence), instead_of)
            transaction = PlanTransaction(connection, self._id_cache)
            if sequence is not None:
                transaction.remove(sequence)
            transaction.add(entries)
        transaction.committed()

    def remove_plan(self, plan_id: str) -> None:
        """Remove a plan; ``NotFound`` if it does not exist."""
        check_name("plan", plan_id)
        with self._connections.writing() as connection:
            PlanTransaction(connection, self._id_cache).remove(_existing_sequence(connection, plan_id))

    def remove_plans(self, map_id: str) -> int:
        """Remove the plans of a map in several transactions, between which others can write; return their number."""
        check_name("map", map_id)
        removed = 0
        while True:
            with self._connections.writing() as connection:
                some = remove_span(connection, map_id, PlanTransaction(connection, self._id_cache).remove)
            if some is None:
                return removed
            removed += some

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if it does not exist."""
        check_name("plan", plan_id)
        with self._connections.reading_snapshot() as connection:
            return _whole(connection, _existing_sequence(connection, plan_id))

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return the stored plans among these ids, by id."""
        wanted = [check_name("plan", plan_id) for plan_id in plan_ids]
        with self._connections.reading_snapshot() as connection:
            sequences = list(sequences_of(connection, wanted).values())
            return {record.id: record for record in _wholes(connection, sequences)}

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        check_name("map", map_id)
        with self._connections.reading_snapshot() as connection:
            return list(itertools.islice(_newest(connection, map_id, before or (math.inf, "")), limit))

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted."""
        query = "SELECT DISTINCT map FROM contexts JOIN scopes ON scopes.id = scope ORDER BY map"
        with self._connections.reading() as connection:
            return [map_id for (map_id,) in connection.execute(query)]

    def find_plans(self, search: PlanStoreQuery, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans that begin and end near two places, shortest first."""
        with self._connections.reading_snapshot() as connection:
            found = plans_between(connection, search, limit)
        return sorted(found, key=lambda head: (head.length, head.id))

    def plans_through(self, search: PlanStoreQuery, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, shortest passage first."""
        with self._connections.reading_snapshot() as connection:
            return search.passages(_wholes(connection, _passing(connection, search)), limit)

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the shared segments of a plan, in order; ``NotFound`` if the plan does not exist."""
        check_name("plan", plan_id)
        query = "SELECT waypoints, data, refs FROM chunks JOIN chunk_refs ON chunk = id WHERE id = ?"
        parts, first = [], ENDS_BEFORE
        with self._connections.reading_snapshot() as connection:
            sequence = _existing_sequence(connection, plan_id)
            row = _row(connection, sequence)
            common, later = context_of(row.context), Counter(uncounted(connection)[1].tolist())
            scope = scope_of(common.map, common.version)
            for chunk in read_recipe(row.recipe):
                count, data, refs = connection.execute(query, (chunk,)).fetchone()
                parts.append(PlanPart(entry_id(scope, unpack(data)).hex(), first, count, refs + later[chunk]))
                first += count
        return parts

    def plan_faults(self) -> Iterator[str]:
        """Yield the plans that cannot be read, and the segments whose content does not match their hash."""
        with self._connections.reading() as connection:
            yield from plan_faults(connection)
            yield from segment_faults(connection)

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans."""
        if map_id is not None:
            check_name("map", map_id)
        of_map = "(SELECT id FROM scopes WHERE map = coalesce(?, map))"
        plans = f"SELECT sum(plans), sum(waypoints), sum(loose), sum(bytes) FROM contexts WHERE scope IN {of_map}"
        chunks = f"SELECT count(*), sum(waypoints), sum(length(data)) FROM chunks WHERE scope IN {of_map}"
        with self._connections.reading_snapshot() as connection:
            count, waypoints, loose, size = (total or 0 for total in connection.execute(plans, (map_id,)).fetchone())
            entries, shared, data = (total or 0 for total in connection.execute(chunks, (map_id,)).fetchone())
            scopes = {scope for (scope,) in connection.execute(of_map[1:-1], (map_id,))}
            later = [plan for plan in uncounted(connection)[0] if plan.scope in scopes]
        return PlanStatistics(
            plans=count + len(later),
            waypoints=waypoints + sum(plan.waypoints for plan in later),
            kept=loose + shared + sum(plan.unshared for plan in later),
            entries=entries,
            bytes=size + data + sum(plan.bytes for plan in later),
        )


def _existing_sequence(connection: sqlite3.Connection, plan_id: str) -> int:
    sequence = sequence_of(connection, plan_id)
    if sequence is None:
        raise NotFound("plan", plan_id)
    return sequence


def _whole(connection: sqlite3.Connection, sequence: int) -> PlanRecord:
    """Return a plan; ``Unavailable`` if it is damaged."""
    row = _row(connection, sequence)
    return _assembled(row, intact_segments(connection, set(read_recipe(row.recipe))))


def _wholes(connection: sqlite3.Connection, sequences: Iterable[int]) -> Iterator[PlanRecord]:
    """Yield the plans of these sequence numbers that can be read; segments that they share are read once."""
    rows = readable_rows([PlanRow(*row) for row in rows_of(connection, _WHOLES, list(sequences))])
    data = intact_segments(connection, set(itertools.chain.from_iterable(read_recipe(row.recipe) for row in rows)))
    for row in rows:
        try:
            whole = _assembled(row, data)
        except Unavailable as error:
            logger.error("a plan is left out: %s", error)
        else:
            yield whole


def _assembled(row: PlanRow, segments: Mapping[int, bytes]) -> PlanRecord:
    recipe = read_recipe(row.recipe)
    if not segments.keys() >= set(recipe):
        raise damaged(row.place, "a segment is missing or damaged")
    try:
        shared = [poses_in([segments[chunk] for chunk in recipe])] if recipe else []
    except Unavailable as error:
        raise damaged(row.place, error) from error
    return record_of(row.context, row.body, shared)


def _row(connection: sqlite3.Connection, sequence: int) -> PlanRow:
    """Return the row of a plan; ``Unavailable`` if it is damaged."""
    row = PlanRow(*connection.execute(_PLAN, (sequence,)).fetchone())
    row.check()
    return row


def _newest(connection: sqlite3.Connection, map_id: str, before: tuple[float, str]) -> Iterator[PlanRecord]:
    """Yield the heads of the plans of a map before the key ``before`` (time, id), newest first."""
    spans = connection.execute(
        """SELECT span, max(newest) AS latest FROM plan_spans JOIN scopes ON id = scope
           WHERE map = ? AND oldest <= ? GROUP BY span ORDER BY latest DESC""",
        (map_id, before[0]),
    ).fetchall()
    # Spans with uncounted plans have unknown times, and are read first.
    query = "SELECT DISTINCT sequence / ? FROM plans WHERE sequence > ?"
    open_spans = [span for (span,) in connection.execute(query, (SPAN, counted_up_to(connection)))]
    spans = [*((span, math.inf) for span in open_spans), *(each for each in spans if each[0] not in open_spans)]
    waiting: list[tuple[float, str, PlanRecord]] = []
    latest = [latest for _, latest in spans[1:]]
    for (span, _), next_latest in zip(spans, [*latest, -math.inf], strict=False):
        heads = [head for head in _heads(connection, map_id, span) if (head.created, head.id) < before]
        waiting = sorted([*waiting, *((head.created, head.id, head) for head in heads)], key=lambda each: each[:2])
        while waiting and waiting[-1][0] > next_latest:
            yield waiting.pop()[2]


def _heads(connection: sqlite3.Connection, map_id: str, span: int) -> Iterator[PlanRecord]:
    query = f"""SELECT {COLUMNS} FROM plans JOIN contexts ON contexts.id = context JOIN scopes ON scopes.id = scope
                WHERE sequence BETWEEN ? AND ? AND map = ?"""
    rows = connection.execute(query, (span * SPAN, span * SPAN + SPAN - 1, map_id))
    for row, own in readable([PlanRow(*row) for row in rows]):
        yield head_of(row.context, own)


def _passing(connection: sqlite3.Connection, search: PlanStoreQuery) -> Iterator[int]:
    """Yield up to `MAX_PLANS` sequence numbers of plans with an entry near each of the two places."""
    scope, tolerance = search.scope, search.tolerance
    near_start, near_goal = (_near(connection, scope, place, tolerance) for place in (search.start, search.goal))
    sampled = [set(itertools.chain(*near.values())) for near in (near_start, near_goal)]
    query = "SELECT sequence FROM plans WHERE sequence > ?"
    later = {sequence for (sequence,) in connection.execute(query, (counted_up_to(connection),))}
    # Candidates: first plans sampled at both places, then those sampled at one, then uncounted ones, which have no
    # samples yet. The recipe of a plan shows whether it has entries near both places.
    both = sorted(sampled[0] & sampled[1])
    either = sorted(sampled[0] ^ sampled[1])[:MAX_CHUNKS]
    likely = dict.fromkeys((*both[:MAX_CHUNKS], *either, *sorted(later)))
    rows = readable_rows([PlanRow(*row) for row in rows_of(connection, _WHOLES, list(likely))])
    recipes = {row.sequence: row.recipe for row in rows}
    plans = [plan for plan in likely if plan in recipes]
    chunks, stops = numbers_in([recipes[plan] for plan in plans])
    passes = [np.isin(chunks, list(near)).astype(np.int64) for near in (near_start, near_goal)]
    begins = np.concatenate(([0], stops[:-1]))
    counts = [np.concatenate(([0], np.cumsum(each))) for each in passes]
    both_near = np.all([count[stops] > count[begins] for count in counts], axis=0)
    yield from [plan for plan, near in zip(plans, both_near.tolist(), strict=True) if near][:MAX_PLANS]


def _near(
    connection: sqlite3.Connection, scope: bytes, place: Position, tolerance: float
) -> dict[int, tuple[int, ...]]:
    """Return the entries with a waypoint near a place, and the sampled plans that refer to each."""
    found: dict[int, tuple[int, ...]] = {}
    query = """SELECT id, data, crc, plans FROM chunk_places JOIN chunks ON id = chunk WHERE place = ?
               ORDER BY id LIMIT ?"""
    for cell in cells_near(place, tolerance):
        for chunk, data, crc, plans in connection.execute(query, (cell_number(scope, cell), MAX_CHUNKS)):
            if is_intact(data, crc) and comes_near(poses_in([data])[:, :2], place, tolerance):
                found[chunk] = struct.unpack_from(f"<{len(plans) // 4}I", plans)
    return found
