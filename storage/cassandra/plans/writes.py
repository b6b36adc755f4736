"""Writes of plans to Cassandra: their order, and the sizes of batches.

A plan exists if its row in ``plans_at_spots`` exists. The rows that name it, by its id and in the list of its map, are
written before that row and deleted after it. An interrupted write leaves names without a plan, which readers skip. So
no write needs a logged batch, which Cassandra writes twice.
"""

from collections.abc import Iterator, Sequence
from operator import attrgetter
from typing import Any

from ppaas.plans.encoding.codes import ID_BYTES
from storage.cassandra.connection.session import MAX_BATCH_BYTES, MAX_BATCH_ROWS, Write
from storage.cassandra.plans.endpoint_cells import cell_key
from storage.cassandra.plans.rows import PlanRow, location_cell, map_key
from storage.records import PlanRecord

_INSERT_ID = "INSERT INTO plans (id, lead) VALUES (?, ?)"
_INSERT_IN_MAP = "INSERT INTO plans_by_map (map, created, id) VALUES (?, ?, ?)"
_INSERT = "INSERT INTO plans_at_spots (bucket, spot, id, head, recipe) VALUES (?, ?, ?, ?, ?)"
_DELETE_FROM_MAP = "DELETE FROM plans_by_map WHERE map = ? AND created = ? AND id = ?"
_DELETE = "DELETE FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"

KEYS_BYTES = 240
"""Approximate overhead of a row of ``plans_at_spots`` as Cassandra counts it [bytes]: keys, and a time per value."""


def insert_names(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
    """Yield groups of writes that name plans, each with as many partitions as Cassandra accepts without a warning."""
    for at in range(0, len(rows), MAX_BATCH_ROWS - 1):
        group = rows[at : at + MAX_BATCH_ROWS - 1]
        yield [
            *((_INSERT_ID, (row.record.id, row.location)) for row in group),
            *((_INSERT_IN_MAP, map_key(row.record)) for row in group),
        ]


def insert_plans(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
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


def index_writes(row: PlanRow) -> list[Write]:
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


def _insertion(row: PlanRow) -> Write:
    return _INSERT, (*row.key, row.head, row.recipe)
