"""Tables of the path plan database in an SQLite file, and their migrations.

Rows are small and many, so each index is a separate table without other columns.

- ``scopes``: map versions that have plans.
- ``contexts``: fields that many plans have in common (``storage.plan_entry.PlanContext``), and sums over their plans.
- ``plans``: the body of each plan, the ids of its shared segments (``ppaas.plans.encoding.recipes``), and a checksum of
  both and of its context (``storage.sqlite.plan_rows``).
- ``plan_ids``: plans by a hash of their id.
- ``plan_spots``: plans by length and ends, the *cell* of a plan (``ppaas.plans.encoding.end_buckets``).
- ``plan_spans``: for each scope and each run of ``SPAN`` consecutive plans, their oldest and newest times.
- ``tally``: one row, with the last plan whose sums, times and references are counted (``storage.sqlite.plan_counts``),
  and the number of removals of entries and contexts.
- ``chunks``: the shared segments, called entries, with a checksum of each, and a sample of the plans that refer to it;
  ids are never reused.
- ``chunk_refs``: number of references to each entry; a separate table, because it changes often.
- ``chunk_ids``: entries by the hash of their content.
- ``chunk_places``: entries by the cells of the map that they touch.
"""

import sqlite3

SPAN = 256

BEFORE_PLAN_TABLES = ("DROP INDEX plans_by_map", "ALTER TABLE plans RENAME TO plans_before")

PLAN_TABLES = (
    """CREATE TABLE scopes (id INTEGER PRIMARY KEY, map TEXT NOT NULL, version TEXT NOT NULL, UNIQUE (map, version))
       STRICT""",
    """CREATE TABLE contexts (id INTEGER PRIMARY KEY AUTOINCREMENT, record BLOB NOT NULL UNIQUE,
       scope INTEGER NOT NULL, plans INTEGER NOT NULL, waypoints INTEGER NOT NULL, loose INTEGER NOT NULL,
       bytes INTEGER NOT NULL) STRICT""",
    """CREATE TABLE plans (sequence INTEGER PRIMARY KEY, context INTEGER NOT NULL, body BLOB NOT NULL,
       recipe BLOB NOT NULL, crc INTEGER) STRICT""",
    "CREATE TABLE plan_ids (hash INTEGER, plan INTEGER, PRIMARY KEY (hash, plan)) STRICT, WITHOUT ROWID",
    "CREATE TABLE plan_spots (spot INTEGER, plan INTEGER, PRIMARY KEY (spot, plan)) STRICT, WITHOUT ROWID",
    """CREATE TABLE plan_spans (scope INTEGER, span INTEGER, oldest REAL NOT NULL, newest REAL NOT NULL,
       PRIMARY KEY (scope, span)) STRICT, WITHOUT ROWID""",
    "CREATE TABLE tally (counted INTEGER NOT NULL, removals INTEGER NOT NULL) STRICT",
    "INSERT INTO tally VALUES (0, 0)",
    """CREATE TABLE chunks (id INTEGER PRIMARY KEY AUTOINCREMENT, scope INTEGER NOT NULL, waypoints INTEGER NOT NULL,
       data BLOB NOT NULL, plans BLOB NOT NULL, crc INTEGER) STRICT""",
    "CREATE TABLE chunk_refs (chunk INTEGER PRIMARY KEY, refs INTEGER NOT NULL) STRICT",
    "CREATE TABLE chunk_ids (entry BLOB PRIMARY KEY, chunk INTEGER NOT NULL) STRICT, WITHOUT ROWID",
    "CREATE TABLE chunk_places (place INTEGER, chunk INTEGER, PRIMARY KEY (place, chunk)) STRICT, WITHOUT ROWID",
)


def renew_plans(connection: sqlite3.Connection) -> None:
    """Recreate the tables, empty, in a file from between two releases: plans can be computed again."""
    tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
    if "tally" in tables:
        return
    for statement in PLAN_TABLES:
        words = statement.split()
        if words[:2] == ["CREATE", "TABLE"] and words[2] in tables:
            connection.execute(f"DROP TABLE {words[2]}")
    for statement in PLAN_TABLES:
        connection.execute(statement)


def add_plan_checksums(connection: sqlite3.Connection) -> None:
    """Add the columns of checksums, which are missing in the rows of earlier releases."""
    for table in ("plans", "chunks"):
        if "crc" not in {name for _, name, *_ in connection.execute(f"PRAGMA table_info({table})")}:
            connection.execute(f"ALTER TABLE {table} ADD COLUMN crc INTEGER")


def move_plans(connection: sqlite3.Connection) -> None:
    """Move plans that an earlier release stored as whole records to the new tables."""
    if connection.execute("SELECT 1 FROM plans_before LIMIT 1").fetchone() is not None:
        from storage.sqlite.plan_writes import add_earlier_plans  # noqa: PLC0415 - imports numba, which few files need

        add_earlier_plans(connection)
    connection.execute("DROP TABLE plans_before")
