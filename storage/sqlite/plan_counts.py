"""Deferred counts of plans in an SQLite file: references to entries, sums, and times of plans, by spans of plans.

A plan refers to some twenty entries, which are on as many pages of the file. So the counts are not updated with each
plan. The table ``tally`` has the last counted plan; a writer that finds more than `MAX_UNCOUNTED` later ones counts
them together, and readers add the uncounted ones. All plans of a map are removed span by span, a transaction each.
"""

import sqlite3
import struct
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE
from ppaas.plans.encoding.recipes import numbers_in
from storage.sqlite.plan_rows import COLUMNS, PlanRow, readable
from storage.sqlite.plan_schema import SPAN

MAX_UNCOUNTED = 2048
"""Largest number of uncounted plans; counting four times as many takes twice as long."""

SAMPLES = 8
"""Largest number of plans that are recorded with an entry as a sample of those that refer to it."""


class Uncounted(msgspec.Struct, frozen=True):
    """A plan that is not counted yet: its sequence number, context, scope, time, and what it adds to the sums.

    A struct, because it is created faster than a dataclass.
    """

    sequence: int
    context: int
    scope: int
    created: float
    waypoints: int
    unshared: int
    bytes: int


def counted_up_to(connection: sqlite3.Connection) -> int:
    """Return the sequence number of the last counted plan."""
    return int(connection.execute("SELECT counted FROM tally").fetchone()[0])


def uncounted(connection: sqlite3.Connection) -> tuple[list[Uncounted], NDArray[np.int64], NDArray[np.int64]]:
    """Return the uncounted plans, the entries that they refer to, and the end of each plan's part of these."""
    query = f"""SELECT {COLUMNS}, context, scope FROM plans JOIN contexts ON contexts.id = context
                WHERE sequence > (SELECT counted FROM tally) ORDER BY sequence"""
    places = {}
    for *row, context, scope in connection.execute(query):
        places[PlanRow(*row)] = context, scope
    read = readable([*places])
    chunks, stops = numbers_in([row.recipe for row, _ in read])
    plans = []
    for row, own in read:
        unshared = ENDS_BEFORE + ENDS_AFTER if own.shared else own.count
        created, size = own.numbers()[0], len(row.body) + len(row.recipe)
        plans.append(Uncounted(row.sequence, *places[row], created, own.count, unshared, size))
    return plans, chunks, stops


def count_plans(connection: sqlite3.Connection) -> None:
    """Count the plans that are not counted yet; damaged ones count for nothing."""
    plans, chunks, stops = uncounted(connection)
    if not plans:
        return
    _count_references(connection, [plan.sequence for plan in plans], chunks, stops)
    sums: dict[int, list[int]] = {}
    spans: dict[tuple[int, int], tuple[float, float]] = {}
    for plan in plans:
        counted = sums.setdefault(plan.context, [0, 0, 0, 0])
        for at, added in enumerate((1, plan.waypoints, plan.unshared, plan.bytes)):
            counted[at] += added
        span, made = (plan.scope, plan.sequence // SPAN), plan.created
        oldest, newest = spans.get(span, (made, made))
        spans[span] = min(oldest, made), max(newest, made)
    for context, counted in sums.items():
        add_to_context(connection, context, counted)
    connection.executemany(
        """INSERT INTO plan_spans VALUES (?, ?, ?, ?) ON CONFLICT DO UPDATE
           SET oldest = min(oldest, excluded.oldest), newest = max(newest, excluded.newest)""",
        [(*span, *times) for span, times in spans.items()],
    )
    connection.execute("UPDATE tally SET counted = ?", (plans[-1].sequence,))


def add_to_context(connection: sqlite3.Connection, context: int, sums: Sequence[int]) -> None:
    """Add to the sums of a context: plans, waypoints, unshared waypoints, bytes."""
    connection.execute(
        """UPDATE contexts SET plans = plans + ?, waypoints = waypoints + ?, loose = loose + ?, bytes = bytes + ?
           WHERE id = ?""",
        (*sums, context),
    )


def _count_references(
    connection: sqlite3.Connection, sequences: list[int], chunks: NDArray[np.int64], stops: NDArray[np.int64]
) -> None:
    places = np.argsort(chunks, kind="stable")
    ids, first, counts = np.unique(chunks[places], return_index=True, return_counts=True)
    # Every entry has a row in `chunk_refs`, and both arrays are sorted by id.
    query = "SELECT refs FROM {given} AS given JOIN chunk_refs ON chunk = given.id ORDER BY chunk"
    before = np.array(rows_of(connection, query, ids.tolist()), np.int64).reshape(-1)
    after = before + counts
    updates = zip(after.tolist(), ids.tolist(), strict=True)
    samples = []
    # Sample the plans of the 1st, 2nd, 4th, 8th … reference, so that samples are spread over time.
    for at in np.flatnonzero(_doublings(before) != _doublings(after)).tolist():
        refs = int(before[at])
        for slot in range(refs.bit_length(), int(after[at]).bit_length()):
            plan = int(np.searchsorted(stops, places[first[at] + (1 << slot) - refs - 1], side="right"))
            samples.append((int(ids[at]), slot % SAMPLES, sequences[plan]))
    connection.executemany("UPDATE chunk_refs SET refs = ? WHERE chunk = ?", updates)
    for chunk, slot, sequence in samples:
        _put_sample(connection, chunk, slot, sequence)


def _doublings(counts: NDArray[np.int64]) -> NDArray[np.int32]:
    return np.frexp(counts.astype(np.float64))[1]


def _put_sample(connection: sqlite3.Connection, chunk: int, slot: int, sequence: int) -> None:
    before = connection.execute("SELECT plans FROM chunks WHERE id = ?", (chunk,)).fetchone()[0]
    samples = bytearray(before.ljust(4 * slot + 4, b"\0"))
    struct.pack_into("<I", samples, 4 * slot, sequence)
    connection.execute("UPDATE chunks SET plans = ? WHERE id = ?", (bytes(samples), chunk))


def rows_of(connection: sqlite3.Connection, query: str, ids: list[int]) -> list[Any]:
    """Return the rows of a query in which ``{given}`` stands for a table of these ids."""
    return connection.execute(query.format(given="(SELECT value AS id FROM json_each(?))"), (str(ids),)).fetchall()


def remove_span(connection: sqlite3.Connection, map_id: str, remove: Callable[[int], None]) -> int | None:
    """Remove the plans of a map that belong to one span, and the span's row.

    Parameters
    ----------
    connection : sqlite3.Connection
        Connection in a write transaction.
    map_id : str
    remove : callable
        Removes the plan of a sequence number in the same transaction.

    Returns
    -------
    int or None
        Number of removed plans. None if the map has no more spans; then its scopes are removed too.
    """
    count_plans(connection)  # brings `plan_spans` up to date
    query = "SELECT scope, span FROM plan_spans JOIN scopes ON id = scope WHERE map = ? LIMIT 1"
    row = connection.execute(query, (map_id,)).fetchone()
    if row is None:
        connection.execute("DELETE FROM scopes WHERE map = ?", (map_id,))
        return None
    scope, span = row
    query = """SELECT sequence FROM plans JOIN contexts ON contexts.id = context
               WHERE sequence BETWEEN ? AND ? AND scope = ?"""
    sequences = connection.execute(query, (span * SPAN, span * SPAN + SPAN - 1, scope)).fetchall()
    for (sequence,) in sequences:
        remove(sequence)
    connection.execute("DELETE FROM plan_spans WHERE scope = ? AND span = ?", row)
    return len(sequences)
