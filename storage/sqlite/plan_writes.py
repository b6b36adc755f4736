"""Writing and removing plans in the tables of an SQLite file, in a write transaction."""

import itertools
import logging
import sqlite3
import threading
import zlib
from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.body import PlanBody
from ppaas.plans.encoding.end_buckets import index_keys_of
from ppaas.plans.encoding.granularity import GRANULARITY, inner_granularity
from ppaas.plans.encoding.index_cells import scope_of
from ppaas.plans.encoding.recipes import read_recipe, recipes_of
from storage.encoding import decode
from storage.plan_entry import PlanEntry, context_of, entries_of
from storage.records import PlanRecord
from storage.sqlite.plan_counts import MAX_UNCOUNTED, add_to_context, count_plans, rows_of
from storage.sqlite.plan_rows import COLUMNS, PlanRow, checksum, readable
from storage.sqlite.plan_segments import find_or_add, remove_segment

logger = logging.getLogger(__name__)

MAX_REMEMBERED, MAX_CONTEXTS = 1 << 17, 1 << 12
"""Sizes of the id cache: entries (some 30 MB), and contexts, whose parameters may be long."""

_AT_ONCE = 512

_OF_HASH = f"""SELECT {COLUMNS} FROM plan_ids JOIN plans ON sequence = plan JOIN contexts ON contexts.id = context
    WHERE hash = ?"""
_OF_HASHES = f"""SELECT {COLUMNS} FROM {{given}} AS sought JOIN plan_ids ON hash = sought.id
    JOIN plans ON sequence = plan JOIN contexts ON contexts.id = context"""

Value = TypeVar("Value")


@dataclass(slots=True)
class KnownIds:
    """Row ids in the file.

    Parameters
    ----------
    chunks : dict
        Ids of entries by scope and code.
    contexts : dict
        Ids of contexts and of their scopes by encoded context.
    """

    chunks: dict[bytes, int] = field(default_factory=dict)
    contexts: dict[bytes, tuple[int, int]] = field(default_factory=dict)


class IdCache:
    """Cache of the row ids of entries and contexts. Thread-safe.

    It is valid until any process removes an entry or a context; the file counts these removals.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._removals = 0
        self._ids = KnownIds()

    def known(self, removals: int) -> KnownIds:
        """Return the cached ids, read-only; none if the file's count of removals has changed."""
        with self._lock:
            return self._ids if removals == self._removals else KnownIds()

    def learn(self, ids: KnownIds, removals: int) -> None:
        """Add ids, after they were committed: after a rollback an id may be assigned to another row."""
        if not ids.chunks and not ids.contexts:
            return
        with self._lock:
            if removals < self._removals:
                return
            if removals > self._removals:
                self._ids, self._removals = KnownIds(), removals
            _add_bounded(self._ids.chunks, ids.chunks, MAX_REMEMBERED)
            _add_bounded(self._ids.contexts, ids.contexts, MAX_CONTEXTS)


class PlanTransaction:
    """Adds and removes plans in one transaction.

    Parameters
    ----------
    connection : sqlite3.Connection
        Connection in a write transaction.
    id_cache : IdCache
        Gets the ids that this transaction learns, once it is committed.
    """

    def __init__(self, connection: sqlite3.Connection, id_cache: IdCache) -> None:
        self._connection = connection
        self._id_cache = id_cache
        self._learned = KnownIds()
        query = "SELECT counted, removals, (SELECT coalesce(max(sequence), 0) FROM plans) FROM tally"
        self._counted, self._removals, self._last = connection.execute(query).fetchone()

    def committed(self) -> None:
        """Add the learned ids to the cache; call it after the commit."""
        self._id_cache.learn(self._learned, self._removals)

    def add(self, *given: Iterable[PlanEntry]) -> list[int]:
        """Add plans; return the number of new ones of each argument. Of plans with the same id, the first is added."""
        added = [0] * len(given)
        left = ((number, entry) for number, entries in enumerate(given) for entry in entries)
        while batch := list(itertools.islice(left, _AT_ONCE)):
            by_id: dict[str, tuple[int, PlanEntry]] = {}
            for each in batch:
                by_id.setdefault(each[1].id, each)
            for plan_id in sequences_of(self._connection, by_id):
                del by_id[plan_id]
            if by_id:
                self._add([entry for _, entry in by_id.values()])
            for number, _ in by_id.values():
                added[number] += 1
        return added

    def remove(self, sequence: int) -> None:
        """Remove a plan, and the entries that no other plan refers to."""
        count_plans(self._connection)
        query = f"SELECT context, {COLUMNS} FROM plans JOIN contexts ON contexts.id = context WHERE sequence = ?"
        context, *columns = self._connection.execute(query, (sequence,)).fetchone()
        read = readable([PlanRow(*columns)])
        if read:
            self._remove_readable(context, *read[0])
        else:
            self._remove_damaged(sequence)
        # SQLite reuses the sequence number if the last plan was removed, so `counted` must not be beyond it.
        set_counted = "UPDATE tally SET counted = (SELECT coalesce(max(sequence), 0) FROM plans) RETURNING counted"
        self._counted = self._last = self._one(set_counted)

    def _remove_readable(self, context: int, row: PlanRow, own: PlanBody) -> None:
        common = context_of(row.context)
        scope = scope_of(common.map, common.version)
        shared = sum(self._release(scope, chunk, refs) for chunk, refs in Counter(read_recipe(row.recipe)).items())
        length = np.array([own.numbers()[1]])
        [index_key] = index_keys_of([scope], np.array(own.ends()).reshape(1, 4), length).tolist()
        execute = self._connection.execute
        execute("DELETE FROM plans WHERE sequence = ?", (row.sequence,))
        execute("DELETE FROM plan_ids WHERE hash = ? AND plan = ?", (_hash(own.plan_id), row.sequence))
        execute("DELETE FROM plan_spots WHERE spot = ? AND plan = ?", (index_key, row.sequence))
        size = len(row.body) + len(row.recipe)
        add_to_context(self._connection, context, (-1, -own.count, shared - own.count, -size))
        if execute("DELETE FROM contexts WHERE id = ? AND plans = 0", (context,)).rowcount:
            self._forget()

    def _remove_damaged(self, sequence: int) -> None:
        """Remove a plan that cannot be read. Its segments stay, and so do the sums that it is part of."""
        for table, column in (("plans", "sequence"), ("plan_ids", "plan"), ("plan_spots", "plan")):
            self._connection.execute(f"DELETE FROM {table} WHERE {column} = ?", (sequence,))

    def _add(self, entries: list[PlanEntry]) -> None:
        contexts = self._contexts({entry.context for entry in entries})
        numbers = self._chunks(entries, {entry.scope: contexts[entry.context][1] for entry in entries})
        recipes = recipes_of(
            numbers, np.array(list(itertools.accumulate(len(entry.codes) for entry in entries)), np.int64)
        )
        numbered = list(enumerate(entries, self._last + 1))
        many = self._connection.executemany
        many(
            "INSERT INTO plans (sequence, context, body, recipe, crc) VALUES (?, ?, ?, ?, ?)",
            [
                (number, contexts[entry.context][0], entry.body, recipe, checksum(entry.context, entry.body, recipe))
                for (number, entry), recipe in zip(numbered, recipes, strict=True)
            ],
        )
        # Sorted, so that neighbouring rows hit the same page.
        many("INSERT INTO plan_ids VALUES (?, ?)", sorted((_hash(entry.id), number) for number, entry in numbered))
        many("INSERT INTO plan_spots VALUES (?, ?)", sorted((entry.index_key, number) for number, entry in numbered))
        self._last += len(entries)
        # Counted together: the references of one plan are on a dozen pages.
        if self._last - self._counted > MAX_UNCOUNTED:
            count_plans(self._connection)
            self._counted = self._last

    # -- contexts ------------------------------------------------------------------------------------------------------

    def _contexts(self, wanted: set[bytes]) -> dict[bytes, tuple[int, int]]:
        """Return the ids of contexts and of their scopes; create missing ones."""
        known, found = self._id_cache.known(self._removals).contexts, {}
        for data in wanted:
            context = known.get(data) or self._learned.contexts.get(data)
            if context is None:
                context = self._learned.contexts[data] = self._context(data)
            found[data] = context
        return found

    def _context(self, data: bytes) -> tuple[int, int]:
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
        """Return the ids of the entries of these plans, one plan after the other; create missing ones."""
        # In the order of the plans: consecutive segments get consecutive ids, which makes recipes short.
        keys = [entry.scope + code for entry in entries for code in entry.codes]
        chunks = list(map(self._id_cache.known(self._removals).chunks.get, keys))
        return [self._learn(key, scopes) if chunk is None else chunk for key, chunk in zip(keys, chunks, strict=True)]

    def _learn(self, key: bytes, scopes: dict[bytes, int]) -> int:
        """Return the id of an entry that is not in the cache, and learn it."""
        chunk = self._learned.chunks.get(key)
        if chunk is None:
            chunk = self._learned.chunks[key] = self._look_up(key, scopes)
        return chunk

    def _look_up(self, key: bytes, scopes: dict[bytes, int]) -> int:
        return find_or_add(self._connection, key, scopes[key[:16]])

    def _release(self, scope: bytes, chunk: int, count: int) -> int:
        """Drop references to an entry, and remove it with the last one; return the plan's waypoints in it."""
        execute = self._connection.execute
        [waypoints] = execute("SELECT waypoints FROM chunks WHERE id = ?", (chunk,)).fetchone()
        if self._one("UPDATE chunk_refs SET refs = refs - ? WHERE chunk = ? RETURNING refs", count, chunk) == 0:
            remove_segment(self._connection, chunk, scope)
            self._forget()
        return int(waypoints) * count

    # -- both ----------------------------------------------------------------------------------------------------------

    def _forget(self) -> None:
        """Invalidate the id caches of all processes, because an entry or a context was removed."""
        self._removals = self._one("UPDATE tally SET removals = removals + 1 RETURNING removals")
        self._learned = KnownIds()

    def _one(self, query: str, *values: object) -> int:
        [(value,)] = self._connection.execute(query, values).fetchall()
        return int(value)


def sequence_of(connection: sqlite3.Connection, plan_id: str) -> int | None:
    """Return the sequence number of a plan, or None if it does not exist.

    Without a readable plan of that id, the number of a damaged one with the hash of the id is returned.
    """
    found = sequences_of(connection, [plan_id]).get(plan_id)
    if found is None:
        rows = map(PlanRow._make, connection.execute(_OF_HASH, (_hash(plan_id),)))
        found = next((row.sequence for row in rows if not readable([row])), None)
    return found


def sequences_of(connection: sqlite3.Connection, plan_ids: Collection[str]) -> dict[str, int]:
    """Return the sequence numbers of the existing plans among these ids, without damaged ones."""
    hashes = [_hash(plan_id) for plan_id in plan_ids]
    if len(hashes) == 1:  # the common case; joining a table of one row takes twice as long
        rows = connection.execute(_OF_HASH, hashes).fetchall()
    else:
        rows = rows_of(connection, _OF_HASHES, hashes)
    found = {own.plan_id: row.sequence for row, own in readable([PlanRow(*row) for row in rows])}
    return {plan_id: found[plan_id] for plan_id in plan_ids if plan_id in found}


def add_earlier_plans(connection: sqlite3.Connection) -> None:
    """Add the plans that an earlier release stored as whole records."""
    transaction = PlanTransaction(connection, IdCache())
    for (data,) in connection.execute("SELECT record FROM plans_before ORDER BY sequence"):
        record = decode(data, PlanRecord)
        try:
            transaction.add(entries_of([record], inner_granularity(GRANULARITY)))
        except InvalidInput as error:
            logger.warning("a plan of an earlier release was skipped: %s", error)


def _add_bounded(cache: dict[bytes, Value], more: dict[bytes, Value], size: int) -> None:
    cache |= more
    for oldest in list(itertools.islice(cache, max(0, len(cache) - size))):
        del cache[oldest]


def _hash(plan_id: str) -> int:
    return zlib.crc32(plan_id.encode()) - (1 << 31)
