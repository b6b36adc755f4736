"""Migration of the plans of an earlier release, which were whole records, to the tables of plans."""

import sqlite3


def move_plans(connection: sqlite3.Connection) -> None:
    """Move plans that an earlier release stored as whole records to the new tables."""
    if connection.execute("SELECT 1 FROM plans_before LIMIT 1").fetchone() is not None:
        from storage.sqlite.plan_writes import add_earlier_plans  # noqa: PLC0415 - imports numba, which few files need

        add_earlier_plans(connection)
    connection.execute("DROP TABLE plans_before")
