"""All plans of a map out of the tables of an SQLite file, some in each transaction."""

import sqlite3
from collections.abc import Callable

from storage.sqlite.plan_counts import count_plans
from storage.sqlite.plan_schema import SPAN


def remove_span(connection: sqlite3.Connection, map_id: str, remove: Callable[[int], None]) -> int | None:
    """Remove the plans of a map from one span, and what is kept of the span.

    Parameters
    ----------
    connection : sqlite3.Connection
        In a transaction.
    map_id : str
        Of the map.
    remove : callable
        Removes the plan of a number in the same transaction.

    Returns
    -------
    int or None
        How many; None where the map has no span any more, and then nothing tells of it.
    """
    count_plans(connection)  # which tells of the spans
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
