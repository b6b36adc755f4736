"""What is written to Cassandra of plans, in what order, and how much of it together.

A plan is there from the moment when the row is in which it lies. What names it, by its id and in the list of its map,
is written before that and removed after it: who is cut off in between leaves names of nothing, which readers pass over.
So nothing needs a logged batch, which Cassandra writes twice.
"""

from collections.abc import Iterator, Sequence
from operator import attrgetter
from typing import Any

from ppaas.plans.body import read_body
from ppaas.plans.codes import ID_BYTES
from ppaas.plans.squares import Place
from storage.cassandra_plan_rows import PlanRow, ends_of, head_parts, lead_key, led, listed, narrow
from storage.cassandra_session import BYTES_TOGETHER, MOST_TOGETHER, Write
from storage.records import PlanRecord

_LEAD = "INSERT INTO plans (id, lead) VALUES (?, ?)"
_LIST = "INSERT INTO plans_by_map (map, created, id) VALUES (?, ?, ?)"
_LAY = """INSERT INTO plans_by_ends (bucket, length, id, start_x, start_y, goal_x, goal_y, head, recipe)
          VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"""
_UNLIST = "DELETE FROM plans_by_map WHERE map = ? AND created = ? AND id = ?"
_TAKE_UP = "DELETE FROM plans_by_ends WHERE bucket = ? AND length = ? AND id = ?"

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
    ends = read_body(head_parts(row.head)[1]).ends()
    values = _values((*lead_key(row.lead), row.id), ends, row.head, row.recipe)
    return f"{_LAY} USING TIMESTAMP ?", (*values, row.written)


def taking_up(row: Any) -> Write:
    """Return what removes a row in which a plan lies, unless it is written again meanwhile."""
    forget = "DELETE FROM plans_by_ends USING TIMESTAMP ? WHERE bucket = ? AND length = ? AND id = ?"
    return forget, (row.written, row.bucket, row.length, row.id)


def _laid(row: PlanRow) -> Write:
    return _LAY, _values(row.key, ends_of(row.record), row.head, row.recipe)


def _values(key: tuple[bytes, float, str], ends: tuple[Place, Place], head: bytes, recipe: bytes) -> tuple[Any, ...]:
    """Return the values of a row in which a plan lies."""
    start, goal = ends
    return (*key, *map(narrow, (*start, *goal)), head, recipe)
