"""Plans into the tables of an SQLite file and out of them, within a transaction beside which nobody else writes."""

import itertools
import logging
import sqlite3
import threading
import zlib
from collections import Counter
from collections.abc import Collection, Iterable

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.plans.body import id_in, read_body
from ppaas.plans.buckets import place_of, spots_of
from ppaas.plans.chunks import GRANULARITY, inner_granularity
from ppaas.plans.codes import entry_id, pack, poses_of, unpack, waypoints_in
from ppaas.plans.recipes import read_recipe, recipes_of
from ppaas.plans.squares import scope_of, squares_touched
from storage.encoding import decode
from storage.plan_entry import PlanEntry, context_of, entries_of
from storage.records import PlanRecord
from storage.sqlite_plan_tally import MOST_UNCOUNTED, add_to_context, count_plans, rows_of

logger = logging.getLogger(__name__)

MOST_REMEMBERED = 1 << 17
"""Entries of which it is remembered where they are: some 30 MB."""

_AT_ONCE = 512


class RememberedChunks:
    """Where entries are, so that nobody needs to look them up.

    It holds until an entry is removed, by whomever: each time that this happens is counted in the file.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._removals = 0
        self._ids: dict[bytes, int] = {}

    def known(self, removals: int) -> dict[bytes, int]:
        """Return the ids of entries by scope and code, if none was removed since; to be looked at only."""
        with self._lock:
            return self._ids if removals == self._removals else {}

    def learn(self, ids: dict[bytes, int], removals: int) -> None:
        """Remember entries, which must be committed: an id that was taken back may be given to another."""
        with self._lock:
            if not ids or removals < self._removals:
                return
            if removals > self._removals:
                self._ids, self._removals = {}, removals
            self._ids |= ids
            for oldest in list(itertools.islice(self._ids, max(0, len(self._ids) - MOST_REMEMBERED))):
                del self._ids[oldest]


class PlanTransaction:
    """Adds and removes plans.

    Parameters
    ----------
    connection : sqlite3.Connection
        In a transaction.
    remembered : RememberedChunks
        To be told what was learned once that is committed.
    """

    def __init__(self, connection: sqlite3.Connection, remembered: RememberedChunks) -> None:
        self._connection = connection
        self._remembered = remembered
        self._learned: dict[bytes, int] = {}
        query = "SELECT counted, removals, (SELECT coalesce(max(sequence), 0) FROM plans) FROM tally"
        self._counted, self._removals, self._last = connection.execute(query).fetchone()

    def committed(self) -> None:
        """Have remembered what was learned, now that it stays."""
        self._remembered.learn(self._learned, self._removals)

    def add(self, entries: Iterable[PlanEntry]) -> int:
        """Add plans; return how many were not there before. Of an id that comes twice, the first."""
        added, left = 0, iter(entries)
        while batch := list(itertools.islice(left, _AT_ONCE)):
            by_id: dict[str, PlanEntry] = {}
            for entry in batch:
                by_id.setdefault(entry.id, entry)
            kept = sequences_of(self._connection, by_id)
            fresh = [entry for entry in by_id.values() if entry.id not in kept]
            if fresh:
                self._add(fresh)
            added += len(fresh)
        return added

    def remove(self, sequence: int) -> None:
        """Remove a plan, and the entries that no other refers to."""
        count_plans(self._connection)
        query = """SELECT context, record, body, recipe FROM plans JOIN contexts ON contexts.id = context
                   WHERE sequence = ?"""
        context, record, body, recipe = self._connection.execute(query, (sequence,)).fetchone()
        own, common = read_body(body), context_of(record)
        scope = scope_of(common.map, common.version)
        shared = sum(self._release(scope, chunk, refs) for chunk, refs in Counter(read_recipe(recipe)).items())
        length = np.array([own.numbers()[1]])
        [spot] = spots_of([scope], np.array(own.ends()).reshape(1, 4), length).tolist()
        execute = self._connection.execute
        execute("DELETE FROM plans WHERE sequence = ?", (sequence,))
        execute("DELETE FROM plan_ids WHERE hash = ? AND plan = ?", (_hash(own.plan_id), sequence))
        execute("DELETE FROM plan_spots WHERE spot = ? AND plan = ?", (spot, sequence))
        add_to_context(self._connection, context, (-1, -own.count, shared - own.count, -len(body) - len(recipe)))
        execute("DELETE FROM contexts WHERE id = ? AND plans = 0", (context,))
        # The number of the last plan is given again.
        set_counted = "UPDATE tally SET counted = (SELECT coalesce(max(sequence), 0) FROM plans) RETURNING counted"
        self._counted = self._last = self._one(set_counted)

    def _add(self, entries: list[PlanEntry]) -> None:
        contexts = {data: self._context(data) for data in {entry.context for entry in entries}}
        numbers = self._chunks(entries, {entry.scope: contexts[entry.context][1] for entry in entries})
        recipes = recipes_of(
            numbers, np.array(list(itertools.accumulate(len(entry.codes) for entry in entries)), np.int64)
        )
        numbered = list(enumerate(entries, self._last + 1))
        many = self._connection.executemany
        many(
            "INSERT INTO plans VALUES (?, ?, ?, ?)",
            [
                (number, contexts[entry.context][0], entry.body, recipe)
                for (number, entry), recipe in zip(numbered, recipes, strict=True)
            ],
        )
        # In their order, so that neighbours find the page of the one before.
        many("INSERT INTO plan_ids VALUES (?, ?)", sorted((_hash(entry.id), number) for number, entry in numbered))
        many("INSERT INTO plan_spots VALUES (?, ?)", sorted((entry.spot, number) for number, entry in numbered))
        self._last += len(entries)
        if self._last - self._counted > MOST_UNCOUNTED:
            count_plans(self._connection)
            self._counted = self._last

    # -- contexts ------------------------------------------------------------------------------------------------------

    def _context(self, data: bytes) -> tuple[int, int]:
        """Return the ids of a context and its scope, which are made if they are not there."""
        query = "SELECT id, scope FROM contexts WHERE record = ?"
        row = self._connection.execute(query, (data,)).fetchone()
        if row is not None:
            return int(row[0]), int(row[1])
        common = context_of(data)
        of_map = (common.map, common.version)
        self._connection.execute("INSERT INTO scopes (map, version) VALUES (?, ?) ON CONFLICT DO NOTHING", of_map)
        scope = self._one("SELECT id FROM scopes WHERE map = ? AND version = ?", *of_map)
        insert = """INSERT INTO contexts (record, scope, plans, waypoints, loose, bytes) VALUES (?, ?, 0, 0, 0, 0)
                    RETURNING id"""
        return self._one(insert, data, scope), scope

    # -- entries -------------------------------------------------------------------------------------------------------

    def _chunks(self, entries: list[PlanEntry], scopes: dict[bytes, int]) -> list[int]:
        """Return the ids of the entries of these plans, one after the other, made where they are not there."""
        # In their order: neighbours in plans get ids that are neighbours, which makes short recipes.
        keys = [entry.scope + code for entry in entries for code in entry.codes]
        chunks = list(map(self._remembered.known(self._removals).get, keys))
        return [self._learn(key, scopes) if chunk is None else chunk for key, chunk in zip(keys, chunks, strict=True)]

    def _learn(self, key: bytes, scopes: dict[bytes, int]) -> int:
        """Return the id of an entry that no earlier transaction remembers, and keep it in mind."""
        chunk = self._learned.get(key)
        if chunk is None:
            chunk = self._learned[key] = self._look_up(key, scopes)
        return chunk

    def _look_up(self, key: bytes, scopes: dict[bytes, int]) -> int:
        """Return the id of an entry that nobody remembers, made if it is not there."""
        scope, code = key[:16], key[16:]
        entry = entry_id(scope, code)
        row = self._connection.execute("SELECT chunk FROM chunk_ids WHERE entry = ?", (entry,)).fetchone()
        if row is not None:
            return int(row[0])
        insert = "INSERT INTO chunks (scope, waypoints, data, plans) VALUES (?, ?, ?, x'') RETURNING id"
        chunk = self._one(insert, scopes[scope], waypoints_in(code), pack(code))
        self._connection.execute("INSERT INTO chunk_ids VALUES (?, ?)", (entry, chunk))
        self._connection.execute("INSERT INTO chunk_refs VALUES (?, 0)", (chunk,))
        places = [(place_of(scope, square), chunk) for square in squares_touched(poses_of(code)[:, :2])]
        self._connection.executemany("INSERT OR IGNORE INTO chunk_places VALUES (?, ?)", places)
        return chunk

    def _release(self, scope: bytes, chunk: int, count: int) -> int:
        """Count references less, and remove an entry without any; return how many waypoints the plan had of it."""
        execute = self._connection.execute
        waypoints, data = execute("SELECT waypoints, data FROM chunks WHERE id = ?", (chunk,)).fetchone()
        if self._one("UPDATE chunk_refs SET refs = refs - ? WHERE chunk = ? RETURNING refs", count, chunk) == 0:
            code = unpack(data)
            execute("DELETE FROM chunks WHERE id = ?", (chunk,))
            execute("DELETE FROM chunk_refs WHERE chunk = ?", (chunk,))
            execute("DELETE FROM chunk_ids WHERE entry = ?", (entry_id(scope, code),))
            places = [(place_of(scope, square), chunk) for square in squares_touched(poses_of(code)[:, :2])]
            self._connection.executemany("DELETE FROM chunk_places WHERE place = ? AND chunk = ?", places)
            self._removals = self._one("UPDATE tally SET removals = removals + 1 RETURNING removals")
            self._learned.clear()
        return int(waypoints) * count

    def _one(self, query: str, *values: object) -> int:
        [(value,)] = self._connection.execute(query, values).fetchall()
        return int(value)


def sequence_of(connection: sqlite3.Connection, plan_id: str) -> int | None:
    """Return the number of the plan of an id, or None."""
    return sequences_of(connection, [plan_id]).get(plan_id)


def sequences_of(connection: sqlite3.Connection, plan_ids: Collection[str]) -> dict[str, int]:
    """Return the numbers of the plans of these ids that are there."""
    query = """SELECT sequence, body FROM {given} AS sought JOIN plan_ids ON hash = sought.id
               JOIN plans ON sequence = plan"""
    rows = rows_of(connection, query, [_hash(plan_id) for plan_id in plan_ids])
    found = {id_in(body): sequence for sequence, body in rows}
    return {plan_id: found[plan_id] for plan_id in plan_ids if plan_id in found}


def move_plans(connection: sqlite3.Connection) -> None:
    """Keep in the tables what an earlier release kept as whole records, and remove these."""
    transaction = PlanTransaction(connection, RememberedChunks())
    for (data,) in connection.execute("SELECT record FROM plans_before ORDER BY sequence"):
        record = decode(data, PlanRecord)
        try:
            transaction.add(entries_of([record], inner_granularity(GRANULARITY)))
        except InvalidInput as error:
            logger.warning("a plan of an earlier release is left out: %s", error)
    connection.execute("DROP TABLE plans_before")


def _hash(plan_id: str) -> int:
    return zlib.crc32(plan_id.encode()) - (1 << 31)
