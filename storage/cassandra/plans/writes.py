"""What is written to Cassandra of plans, in what order, and how much of it together.

A plan is there from the moment when the row is in which it lies. What names it, by its id and in the list of its map,
is written before that and removed after it: who is cut off in between leaves names of nothing, which readers pass over.
So nothing needs a logged batch, which Cassandra writes twice.
"""

from collections.abc import Iterator, Sequence
from operator import attrgetter
from typing import Any

from ppaas.plans.encoding.codes import ID_BYTES
from storage.cassandra.connection.session import BYTES_TOGETHER, MOST_TOGETHER, Write
from storage.cassandra.plans.endpoint_cells import led
from storage.cassandra.plans.rows import PlanRow, lead_spot, listed
from storage.records import PlanRecord

_LEAD = "INSERT INTO plans (id, lead) VALUES (?, ?)"
_LIST = "INSERT INTO plans_by_map (map, created, id) VALUES (?, ?, ?)"
_LAY = "INSERT INTO plans_at_spots (bucket, spot, id, head, recipe) VALUES (?, ?, ?, ?, ?)"
_UNLIST = "DELETE FROM plans_by_map WHERE map = ? AND created = ? AND id = ?"
_TAKE_UP = "DELETE FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"

KEYS_BYTES = 240
"""Bytes of the row in which a plan lies beside what is its own, about, as Cassandra counts: each value has a time."""


def naming(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
    """Yield what names plans, some at a time: with the list of their map as many partitions as bring no warning."""
    for at in range(0, len(rows), MOST_TOGETHER - 1):
        some = rows[at : at + MOST_TOGETHER - 1]
        yield [*((_LEAD, (row.record.id, row.lead)) for row in some), *((_LIST, listed(row.record)) for row in some)]


def laying(rows: Sequence[PlanRow]) -> Iterator[list[Write]]:
    """Yield what keeps plans, some at a time: as many, in as many partitions, as bring no warning."""
    writes: list[Write] = []
    size, buckets = 0, set[bytes]()
    # Rows that are found in one bucket are one change for Cassandra where they come together.
    for row in sorted(rows, key=attrgetter("key")):
        mine, bucket = row.size + ID_BYTES + KEYS_BYTES, row.key[0]
        if writes and (size + mine > BYTES_TOGETHER or len(buckets | {bucket}) > MOST_TOGETHER):
            yield writes
            writes, size, buckets = [], 0, set()
        writes.append(_laid(row))
        size += mine
        buckets.add(bucket)
    if writes:
        yield writes


def indexing(row: PlanRow) -> list[Write]:
    """Return what has a plan that was replaced found by its map and its ends."""
    return [(_LIST, listed(row.record)), _laid(row)]


def forgetting(record: PlanRecord, but: PlanRecord | None = None) -> list[Write]:
    """Return what has a plan found no more, but where another is found: together, the removal would win."""
    return [
        (forget, key(record))
        for forget, key in ((_UNLIST, listed), (_TAKE_UP, led))
        if but is None or key(record) != key(but)
    ]


def unlisting(map_id: str, row: Any) -> Write:
    """Return what takes a row from the list of a map."""
    return _UNLIST, (map_id, row.created, row.id)


def laying_again(row: Any) -> Write:
    """Return what has a plan found by its ends that lies under its id, as of the time when that was written."""
    return f"{_LAY} USING TIMESTAMP ?", (*lead_spot(row.lead), row.id, row.head, row.recipe, row.written)


def taking_up(row: Any) -> Write:
    """Return what removes a row in which a plan lies, unless it is written again meanwhile."""
    forget = "DELETE FROM plans_at_spots USING TIMESTAMP ? WHERE bucket = ? AND spot = ? AND id = ?"
    return forget, (row.written, row.bucket, row.spot, row.id)


def _laid(row: PlanRow) -> Write:
    return _LAY, (*row.key, row.head, row.recipe)
