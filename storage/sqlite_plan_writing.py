"""Plans into the tables of an SQLite file and out of them, within a transaction beside which nobody else writes."""

import itertools
import logging
import sqlite3
import struct
import threading
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable

from ppaas.errors import InvalidInput
from ppaas.plans.body import read_body
from ppaas.plans.buckets import place_of, scope_of, spot_of, squares_touched
from ppaas.plans.chunks import GRANULARITY, inner_granularity
from ppaas.plans.codes import entry_id, pack, poses_of, unpack, waypoints_in
from ppaas.plans.recipes import read_recipe, write_recipe
from storage.encoding import decode
from storage.plan_entry import PlanEntry, context_of, entries_of
from storage.records import PlanRecord
from storage.sqlite_plan_schema import SPAN

logger = logging.getLogger(__name__)

MOST_REMEMBERED = 1 << 17
"""Entries of which it is remembered where they are: some 30 MB."""

SAMPLES = 8
"""Plans that are told of an entry, however many refer to it."""

_AT_ONCE = 512


class RememberedChunks:
    """Where entries are, so that nobody needs to look them up.

    What is remembered may be gone, but is never another: entries do not change, and their ids are not given twice. So
    who counts one reference more learns whether it is still there.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._ids: dict[bytes, int] = {}
        self._seen: dict[int, int] = {}

    def get(self, code: bytes) -> int | None:
        """Return the id of an entry by its scope and code, or None."""
        return self._ids.get(code)

    def learn(self, ids: dict[bytes, int]) -> None:
        """Remember entries, which must be committed: an id that was taken back may be given to another."""
        with self._lock:
            self._ids |= ids
            for oldest in list(itertools.islice(self._ids, max(0, len(self._ids) - MOST_REMEMBERED))):
                del self._ids[oldest]

    def samples(self, chunks: Iterable[int]) -> list[tuple[int, int]]:
        """Count that a plan refers to entries; return those of which it becomes a sample, and at which place.

        It is at the first, second, fourth, eighth … so that samples are of all times.
        """
        found = []
        with self._lock:
            if len(self._seen) > MOST_REMEMBERED:
                self._seen.clear()
            seen = self._seen
            for chunk in chunks:
                seen[chunk] = count = seen.get(chunk, 0) + 1
                if not count & count - 1:
                    found.append((chunk, (count.bit_length() - 1) % SAMPLES))
        return found


class PlanTransaction:
    """Adds and removes plans.

    Parameters
    ----------
    connection : sqlite3.Connection
        In a transaction.
    remembered : RememberedChunks
        To be told ``learned`` once that is committed.
    """

    def __init__(self, connection: sqlite3.Connection, remembered: RememberedChunks) -> None:
        self._connection = connection
        self._remembered = remembered
        self.learned: dict[bytes, int] = {}

    def add(self, entries: Iterable[PlanEntry]) -> int:
        """Add plans; return how many were not there before. Of an id that comes twice, the first."""
        added, left = 0, iter(entries)
        while batch := list(itertools.islice(left, _AT_ONCE)):
            by_id: dict[str, PlanEntry] = {}
            for entry in batch:
                by_id.setdefault(entry.id, entry)
            fresh = [entry for entry in by_id.values() if sequence_of(self._connection, entry.id) is None]
            self._add(fresh)
            added += len(fresh)
        return added

    def remove(self, sequence: int) -> None:
        """Remove a plan, and the entries that no other refers to."""
        query = """SELECT context, record, body, recipe FROM plans JOIN contexts ON contexts.id = context
                   WHERE sequence = ?"""
        context, record, body, recipe = self._connection.execute(query, (sequence,)).fetchone()
        own, common = read_body(body), context_of(record)
        scope = scope_of(common.map, common.version)
        shared = sum(self._release(scope, chunk, refs) for chunk, refs in Counter(read_recipe(recipe)).items())
        first, last = own.ends()
        spot = spot_of(scope, first, last, own.numbers()[1])
        execute = self._connection.execute
        execute("DELETE FROM plans WHERE sequence = ?", (sequence,))
        execute("DELETE FROM plan_ids WHERE hash = ? AND plan = ?", (_hash(own.plan_id), sequence))
        execute("DELETE FROM plan_spots WHERE spot = ? AND plan = ?", (spot, sequence))
        self._count(context, (-1, -own.count, shared - own.count, -len(body) - len(recipe)))
        execute("DELETE FROM contexts WHERE id = ? AND plans = 0", (context,))

    def _add(self, entries: list[PlanEntry]) -> None:
        if not entries:
            return
        contexts = {entry.context: entry for entry in entries}
        known = {data: self._context(entry) for data, entry in contexts.items()}
        chunks = self._chunks(entries, {data: scope for data, (_, scope) in known.items()})
        next_sequence = self._one("SELECT coalesce(max(sequence), 0) + 1 FROM plans")
        plans, sums = [], defaultdict[int, Counter[str]](Counter)
        spans: dict[tuple[int, int], tuple[float, float]] = {}
        for sequence, entry in enumerate(entries, next_sequence):
            context, scope = known[entry.context]
            parts = [chunks[entry.scope + code] for code in entry.codes]
            recipe = write_recipe(parts)
            plans.append((sequence, context, entry.body, recipe))
            self._sample(sequence, parts)
            size = len(entry.body) + len(recipe)
            sums[context].update(plans=1, waypoints=entry.waypoints, loose=entry.loose, bytes=size)
            span, made = (scope, sequence // SPAN), entry.created
            oldest, newest = spans.get(span, (made, made))
            spans[span] = min(oldest, made), max(newest, made)
        self._insert(entries, plans, spans)
        for context, counted in sums.items():
            self._count(context, tuple(counted[name] for name in ("plans", "waypoints", "loose", "bytes")))

    def _insert(
        self,
        entries: list[PlanEntry],
        plans: list[tuple[int, int, bytes, bytes]],
        spans: dict[tuple[int, int], tuple[float, float]],
    ) -> None:
        many = self._connection.executemany
        many("INSERT INTO plans VALUES (?, ?, ?, ?)", plans)
        numbered = [(entry, plan[0]) for entry, plan in zip(entries, plans, strict=True)]
        # In their order, so that neighbours find the page of the one before.
        many("INSERT INTO plan_ids VALUES (?, ?)", sorted((_hash(entry.id), number) for entry, number in numbered))
        many("INSERT INTO plan_spots VALUES (?, ?)", sorted((entry.spot, number) for entry, number in numbered))
        many(
            """INSERT INTO plan_spans VALUES (?, ?, ?, ?) ON CONFLICT DO UPDATE
               SET oldest = min(oldest, excluded.oldest), newest = max(newest, excluded.newest)""",
            [(*span, *times) for span, times in spans.items()],
        )

    # -- contexts ------------------------------------------------------------------------------------------------------

    def _context(self, entry: PlanEntry) -> tuple[int, int]:
        """Return the ids of a plan's context and scope, which are made if they are not there."""
        query = "SELECT id, scope FROM contexts WHERE record = ?"
        row = self._connection.execute(query, (entry.context,)).fetchone()
        if row is not None:
            return int(row[0]), int(row[1])
        common = context_of(entry.context)
        of_map = (common.map, common.version)
        self._connection.execute("INSERT INTO scopes (map, version) VALUES (?, ?) ON CONFLICT DO NOTHING", of_map)
        scope = self._one("SELECT id FROM scopes WHERE map = ? AND version = ?", *of_map)
        insert = """INSERT INTO contexts (record, scope, plans, waypoints, loose, bytes) VALUES (?, ?, 0, 0, 0, 0)
                    RETURNING id"""
        return self._one(insert, entry.context, scope), scope

    def _count(self, context: int, sums: tuple[int, ...]) -> None:
        self._connection.execute(
            """UPDATE contexts SET plans = plans + ?, waypoints = waypoints + ?, loose = loose + ?, bytes = bytes + ?
               WHERE id = ?""",
            (*sums, context),
        )

    # -- entries -------------------------------------------------------------------------------------------------------

    def _chunks(self, entries: list[PlanEntry], scopes: dict[bytes, int]) -> dict[bytes, int]:
        """Return the ids of all entries of these plans by scope and code, counted and made where they are not there."""
        counts, numbers = Counter[bytes](), dict[bytes, int]()
        for entry in entries:
            counts.update([entry.scope + code for code in entry.codes])
            numbers[entry.scope] = scopes[entry.context]
        found = {key: self.learned.get(key) or self._remembered.get(key) for key in counts}
        known = {key: chunk for key, chunk in found.items() if chunk is not None}
        if not self._refer([(counts[key], chunk) for key, chunk in known.items()]):
            known = {key: chunk for key, chunk in known.items() if self._is_kept(chunk)}
        for key, count in counts.items():
            if key not in known:
                known[key] = self.learned[key] = self._look_up(key, count, numbers)
        return known

    def _refer(self, counted: list[tuple[int, int]]) -> bool:
        """Count references; tell whether all entries were there."""
        counted.sort(key=lambda each: each[1])
        update = "UPDATE chunk_refs SET refs = refs + ? WHERE chunk = ?"
        return not counted or self._connection.executemany(update, counted).rowcount == len(counted)

    def _is_kept(self, chunk: int) -> bool:
        return self._connection.execute("SELECT 1 FROM chunk_refs WHERE chunk = ?", (chunk,)).fetchone() is not None

    def _look_up(self, key: bytes, count: int, numbers: dict[bytes, int]) -> int:
        """Return the id of an entry that nobody remembers, counted, and made if it is not there."""
        scope, code = key[:16], key[16:]
        entry = entry_id(scope, code)
        row = self._connection.execute("SELECT chunk FROM chunk_ids WHERE entry = ?", (entry,)).fetchone()
        if row is not None:
            self._refer([(count, row[0])])
            return int(row[0])
        insert = "INSERT INTO chunks (scope, waypoints, data, plans) VALUES (?, ?, ?, x'') RETURNING id"
        chunk = self._one(insert, numbers[scope], waypoints_in(code), pack(code))
        self._connection.execute("INSERT INTO chunk_ids VALUES (?, ?)", (entry, chunk))
        self._connection.execute("INSERT INTO chunk_refs VALUES (?, ?)", (chunk, count))
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
        return int(waypoints) * count

    def _sample(self, sequence: int, chunks: list[int]) -> None:
        for chunk, slot in self._remembered.samples(chunks):
            before = self._connection.execute("SELECT plans FROM chunks WHERE id = ?", (chunk,)).fetchone()[0]
            plans = bytearray(before.ljust(4 * slot + 4, b"\0"))
            struct.pack_into("<I", plans, 4 * slot, sequence)
            self._connection.execute("UPDATE chunks SET plans = ? WHERE id = ?", (bytes(plans), chunk))

    def _one(self, query: str, *values: object) -> int:
        [(value,)] = self._connection.execute(query, values).fetchall()
        return int(value)


def sequence_of(connection: sqlite3.Connection, plan_id: str) -> int | None:
    """Return the number of the plan of an id, or None."""
    query = "SELECT sequence, body FROM plan_ids JOIN plans ON sequence = plan WHERE hash = ?"
    for sequence, body in connection.execute(query, (_hash(plan_id),)):
        if read_body(body).plan_id == plan_id:
            return int(sequence)
    return None


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
