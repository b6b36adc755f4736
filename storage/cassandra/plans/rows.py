"""A plan as rows: its own data, its cell in the index, and the ids of the entries that it refers to.

A plan refers to its *context*, fields that many plans have in common, and to its shared segments. Both are entries,
stored under a hash of themselves, so concurrent or repeated writes of an entry are equal.

A plan exists if its row in ``plans_at_spots`` exists. The rows that name it, by its id and in the list of its map, are
written before that row and deleted after it. An interrupted write leaves names without a plan, which readers skip. So
no write needs a logged batch, which Cassandra writes twice.
"""

import hashlib
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter
from typing import Any

from ppaas.errors import Unavailable
from ppaas.plans.encoding.body import PlanBody
from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE
from ppaas.plans.encoding.codes import ID_BYTES, entry_id
from storage.cassandra.connection.session import MAX_BATCH_BYTES, MAX_BATCH_ROWS, CassandraSession, Write
from storage.cassandra.plans.endpoint_cells import Cell, cell_key
from storage.plan_entry import PlanEntry, entries_of
from storage.records import PlanRecord

MAX_IDS_PER_ROW = 256
"""Largest number of ids in a recipe. A longer one is cut into *sheets*, which are entries, so that rows stay small."""

_IDS, _SHEETS = b"\x00", b"\x01"
_LOCATION = struct.Struct("<16sq8s")

_known_id = lru_cache(1 << 15)(entry_id)
"""Cached ids: most segments of a plan occur in earlier plans."""


@dataclass(frozen=True, slots=True)
class UnwrittenPlan:
    """A plan before it is written.

    Parameters
    ----------
    record : PlanRecord
        The original plan.
    entry : PlanEntry
        Its parts.
    context : bytes
        Id of its context.
    recipe : bytes
        Ids of its segments or, for very many segments, of the sheets with these ids.
    segments : dict
        Codes of its segments by id, in order, each once.
    beside : dict
        Its other entries by id: context and sheets.
    key : tuple
        Its primary key in ``plans_at_spots`` (``endpoint_cells.cell_key``).
    """

    record: PlanRecord
    entry: PlanEntry
    context: bytes
    recipe: bytes
    segments: dict[bytes, bytes]
    beside: dict[bytes, bytes]
    key: tuple[bytes, int, str]

    @property
    def size(self) -> int:
        """Size of its data alone [bytes]."""
        return len(self.entry.body) + len(self.recipe)

    @property
    def cell(self) -> Cell:
        """Its cell in the index."""
        return self.key[:2]

    @property
    def head(self) -> bytes:
        """Id of its context with its body (``head_parts``)."""
        return self.context + self.entry.body

    @property
    def location(self) -> bytes:
        """Its cell (``location_cell``) with a hash of its content: the column ``lead`` of ``plans``."""
        content = hashlib.blake2b(self.head + self.recipe, digest_size=8).digest()
        return _LOCATION.pack(*self.cell, content)


def plan_rows(records: Sequence[PlanRecord], granularity: int) -> Iterator[UnwrittenPlan]:
    """Yield the rows of plans.

    Raises
    ------
    InvalidInput
        A plan is not valid (``storage.plan_checks``).
    """
    for record, entry in zip(records, entries_of(records, granularity), strict=True):
        ids = [_known_id(entry.scope, code) for code in entry.codes]
        context = _known_id(entry.scope, entry.context)
        sheets = dict(_sheets(entry.scope, ids))
        recipe = _SHEETS + b"".join(sheets) if sheets else _IDS + b"".join(ids)
        segments = dict(zip(ids, entry.codes, strict=True))
        yield UnwrittenPlan(
            record, entry, context, recipe, segments, {context: entry.context, **sheets}, cell_key(record)
        )


def ids_in(recipe: bytes) -> tuple[list[bytes], bool]:
    """Return the ids in a recipe, and whether they name sheets.

    Raises
    ------
    Unavailable
        The recipe is damaged.
    """
    if recipe[:1] not in (_IDS, _SHEETS) or len(recipe) % ID_BYTES != 1:
        raise Unavailable("the recipe of a stored plan is damaged: restore the keyspace from a backup")
    return ids_on(recipe[1:]), recipe[:1] == _SHEETS


def ids_on(sheet: bytes) -> list[bytes]:
    """Return the ids on a sheet."""
    return [sheet[at : at + ID_BYTES] for at in range(0, len(sheet), ID_BYTES)]


def head_parts(head: bytes) -> tuple[bytes, bytes]:
    """Return the id of the context in a head, and the body."""
    return head[:ID_BYTES], head[ID_BYTES:]


def location_cell(location: bytes) -> Cell:
    """Return the cell in a location."""
    bucket, spot, _ = _LOCATION.unpack(location)
    return bucket, spot


def unshared_in(body: PlanBody) -> int:
    """Return the number of waypoints that are stored for a plan alone."""
    return ENDS_BEFORE + ENDS_AFTER if body.shared else body.count


def _sheets(scope: bytes, ids: list[bytes]) -> Iterator[tuple[bytes, bytes]]:
    if len(ids) > MAX_IDS_PER_ROW:
        for at in range(0, len(ids), MAX_IDS_PER_ROW):
            sheet = b"".join(ids[at : at + MAX_IDS_PER_ROW])
            yield entry_id(scope, sheet), sheet


def map_key(record: PlanRecord) -> tuple[str, float, str]:
    """Return the primary key of a plan in the list of its map: map, time, and id."""
    return record.map, record.created + 0.0, record.id  # + 0.0, because -0 would sort before 0


# -- stored plans by id: first the cell of each plan, then the row in that cell ----------------------------------------

_LOCATIONS = "SELECT id, lead, head, recipe FROM plans WHERE id = ?"
_STORED = "SELECT head, recipe FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"


@dataclass(frozen=True, slots=True)
class KeptPlan:
    """A stored plan.

    Parameters
    ----------
    id : str
    location : bytes
        Its cell and a hash of its content (``storage.cassandra.plans.rows``).
    replaced : bool
        Whether it was replaced by ``replace_plan``, and is therefore also stored in ``plans``.
    head, recipe : bytes
        Id of its context with its body, and ids of its segments.
    """

    id: str
    location: bytes
    replaced: bool
    head: bytes
    recipe: bytes

    @property
    def context(self) -> bytes:
        """Id of its context."""
        return head_parts(self.head)[0]

    @property
    def body(self) -> bytes:
        """Data of this plan alone (``ppaas.plans.encoding.body``)."""
        return head_parts(self.head)[1]


def kept_plans(session: CassandraSession, plan_ids: Sequence[str]) -> list[KeptPlan | None]:
    """Return the stored plan of each id; None where it does not exist, or was not written completely."""
    located = session.rows_each(_LOCATIONS, [(plan_id,) for plan_id in plan_ids])
    not_inline = [row for rows in located for row in rows if row.head is None]
    stored = iter(session.rows_each(_STORED, [(*location_cell(row.lead), row.id) for row in not_inline]))
    kept: list[KeptPlan | None] = [None] * len(located)
    for number, rows in enumerate(located):
        for row in rows:
            replaced = row.head is not None
            for whole in rows if replaced else next(stored):
                kept[number] = KeptPlan(row.id, row.lead, replaced, whole.head, whole.recipe)
    return kept


# -- writes: their order, and the sizes of batches ---------------------------------------------------------------------

_INSERT_ID = "INSERT INTO plans (id, lead) VALUES (?, ?)"
_INSERT_IN_MAP = "INSERT INTO plans_by_map (map, created, id) VALUES (?, ?, ?)"
_INSERT = "INSERT INTO plans_at_spots (bucket, spot, id, head, recipe) VALUES (?, ?, ?, ?, ?)"
_DELETE_FROM_MAP = "DELETE FROM plans_by_map WHERE map = ? AND created = ? AND id = ?"
_DELETE = "DELETE FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"

KEYS_BYTES = 240
"""Approximate overhead of a row of ``plans_at_spots`` as Cassandra counts it [bytes]: keys, and a time per value."""


def insert_names(rows: Sequence[UnwrittenPlan]) -> Iterator[list[Write]]:
    """Yield groups of writes that name plans, each with as many partitions as Cassandra accepts without a warning."""
    for at in range(0, len(rows), MAX_BATCH_ROWS - 1):
        group = rows[at : at + MAX_BATCH_ROWS - 1]
        yield [
            *((_INSERT_ID, (row.record.id, row.location)) for row in group),
            *((_INSERT_IN_MAP, map_key(row.record)) for row in group),
        ]


def insert_plans(rows: Sequence[UnwrittenPlan]) -> Iterator[list[Write]]:
    """Yield groups of writes that store plans, each as large as Cassandra accepts without a warning."""
    writes: list[Write] = []
    size, buckets = 0, set[bytes]()
    # Sorted, because rows of one bucket in a batch are a single mutation for Cassandra.
    for row in sorted(rows, key=attrgetter("key")):
        mine, bucket = row.size + ID_BYTES + KEYS_BYTES, row.key[0]
        if writes and (size + mine > MAX_BATCH_BYTES or len(buckets | {bucket}) > MAX_BATCH_ROWS):
            yield writes
            writes, size, buckets = [], 0, set()
        writes.append(_insertion(row))
        size += mine
        buckets.add(bucket)
    if writes:
        yield writes


def index_writes(row: UnwrittenPlan) -> list[Write]:
    """Return writes that add the replacement of a plan to the indexes by map and by ends."""
    return [(_INSERT_IN_MAP, map_key(row.record)), _insertion(row)]


def index_deletions(record: PlanRecord, but: PlanRecord | None = None) -> list[Write]:
    """Return deletions of a plan from the indexes, except of rows that a plan ``but`` has too.

    In one batch, a deletion and an insertion of the same row have the same time, and the deletion would win.
    """
    return [
        (delete, key(record))
        for delete, key in ((_DELETE_FROM_MAP, map_key), (_DELETE, cell_key))
        if but is None or key(record) != key(but)
    ]


def delete_listed(map_id: str, newest: Any, oldest: Any) -> Write:
    """Return the deletion of the rows of the list of a map from one to another: by a range, one tombstone for all."""
    delete = "DELETE FROM plans_by_map WHERE map = ? AND (created, id) <= (?, ?) AND (created, id) >= (?, ?)"
    return delete, (map_id, newest.created, newest.id, oldest.created, oldest.id)


def delete_bucket(bucket: bytes) -> Write:
    """Return the deletion of all plans in a bucket of the index, which covers the deletions of each."""
    return "DELETE FROM plans_at_spots WHERE bucket = ?", (bucket,)


def remove_stored(record: PlanRecord) -> list[Write]:
    """Return the deletions of a plan, except from the list of its map."""
    return [(_DELETE, cell_key(record)), ("DELETE FROM plans WHERE id = ?", (record.id,))]


def rewrite_plan(row: Any) -> Write:
    """Return a write that copies a replaced plan from ``plans`` to ``plans_at_spots``, with the time of that row."""
    return f"{_INSERT} USING TIMESTAMP ?", (*location_cell(row.lead), row.id, row.head, row.recipe, row.written)


def delete_plan(row: Any) -> Write:
    """Return the deletion of a row of ``plans_at_spots``, which has no effect if it is written again meanwhile."""
    delete = "DELETE FROM plans_at_spots USING TIMESTAMP ? WHERE bucket = ? AND spot = ? AND id = ?"
    return delete, (row.written, row.bucket, row.spot, row.id)


def _insertion(row: UnwrittenPlan) -> Write:
    return _INSERT, (*row.key, row.head, row.recipe)
