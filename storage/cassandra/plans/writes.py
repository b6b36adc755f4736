"""What is written to Cassandra of plans, in what order, and how much of it together.

A plan is there from the moment when the row is in which it lies. What names it, by its id and in the list of its map,
is written before that and removed after it: who is cut off in between leaves names of nothing, which readers pass over.
So nothing needs a logged batch, which Cassandra writes twice.
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
"""Bytes of the row in which a plan lies beside what is its own, about, as Cassandra counts: each value has a time."""


def insert_names(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
    """Yield what names plans, some at a time: with the list of their map as many partitions as bring no warning."""
    for at in range(0, len(rows), MAX_BATCH_ROWS - 1):
        some = rows[at : at + MAX_BATCH_ROWS - 1]
        yield [
            *((_INSERT_ID, (row.record.id, row.location)) for row in some),
            *((_INSERT_IN_MAP, map_key(row.record)) for row in some),
        ]


def insert_plans(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
    """Yield what keeps plans, some at a time: as many, in as many partitions, as bring no warning."""
    writes: list[Write] = []
    size, buckets = 0, set[bytes]()
    # Rows that are found in one bucket are one change for Cassandra where they come together.
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
    """Return what has a plan that was replaced found by its map and its ends."""
    return [(_INSERT_IN_MAP, map_key(row.record)), _insertion(row)]


def index_deletions(record: PlanRecord, but: PlanRecord | None = None) -> list[Write]:
    """Return what has a plan found no more, but where another is found: together, the removal would win."""
    return [
        (forget, key(record))
        for forget, key in ((_DELETE_FROM_MAP, map_key), (_DELETE, cell_key))
        if but is None or key(record) != key(but)
    ]


def delete_from_map(map_id: str, row: Any) -> Write:
    """Return what takes a row from the list of a map."""
    return _DELETE_FROM_MAP, (map_id, row.created, row.id)


def rewrite_plan(row: Any) -> Write:
    """Return what has a plan found by its ends that lies under its id, as of the time when that was written."""
    return f"{_INSERT} USING TIMESTAMP ?", (*location_cell(row.lead), row.id, row.head, row.recipe, row.written)


def delete_plan(row: Any) -> Write:
    """Return what removes a row in which a plan lies, unless it is written again meanwhile."""
    forget = "DELETE FROM plans_at_spots USING TIMESTAMP ? WHERE bucket = ? AND spot = ? AND id = ?"
    return forget, (row.written, row.bucket, row.spot, row.id)


def _insertion(row: PlanRow) -> Write:
    return _INSERT, (*row.key, row.head, row.recipe)
