"""Removal of all plans of a map from an SQLite file, a span of plans per transaction."""

import sqlite3
from collections.abc import Callable

from storage.sqlite.plan_counts import count_plans
from storage.sqlite.plan_schema import SPAN


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
