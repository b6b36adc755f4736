"""The tables of the Path Plan Database in an SQLite file.

Rows are small and many, so what is looked for by has tables of its own that hold nothing else.

- ``scopes``: versions of maps that have plans.
- ``contexts``: what many plans have in common (``storage.plan_entry.PlanContext``), and the sums of these plans.
- ``plans``: what is a plan's own, and the ids of the entries that it shares (``ppaas.plans.encoding.recipes``).
- ``plan_ids``: plans by a hash of their id.
- ``plan_spots``: plans by where they begin and end (``ppaas.plans.encoding.end_buckets``).
- ``plan_spans``: for each scope and each ``SPAN`` plans that follow one another, when these were made.
- ``tally``: one row: up to which plan sums, times and references are counted (``storage.sqlite.plan_counts``), and how
  often an entry or a context was removed.
- ``chunks``: the entries, and a few of the plans that refer to each; an id is never given twice.
- ``chunk_refs``: how often plans refer to an entry; beside it, since it changes often.
- ``chunk_ids``: entries by what is in them.
- ``chunk_places``: entries by the squares that they touch.
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
       recipe BLOB NOT NULL) STRICT""",
    "CREATE TABLE plan_ids (hash INTEGER, plan INTEGER, PRIMARY KEY (hash, plan)) STRICT, WITHOUT ROWID",
    "CREATE TABLE plan_spots (spot INTEGER, plan INTEGER, PRIMARY KEY (spot, plan)) STRICT, WITHOUT ROWID",
    """CREATE TABLE plan_spans (scope INTEGER, span INTEGER, oldest REAL NOT NULL, newest REAL NOT NULL,
       PRIMARY KEY (scope, span)) STRICT, WITHOUT ROWID""",
    "CREATE TABLE tally (counted INTEGER NOT NULL, removals INTEGER NOT NULL) STRICT",
    "INSERT INTO tally VALUES (0, 0)",
    """CREATE TABLE chunks (id INTEGER PRIMARY KEY AUTOINCREMENT, scope INTEGER NOT NULL, waypoints INTEGER NOT NULL,
       data BLOB NOT NULL, plans BLOB NOT NULL) STRICT""",
    "CREATE TABLE chunk_refs (chunk INTEGER PRIMARY KEY, refs INTEGER NOT NULL) STRICT",
    "CREATE TABLE chunk_ids (entry BLOB PRIMARY KEY, chunk INTEGER NOT NULL) STRICT, WITHOUT ROWID",
    "CREATE TABLE chunk_places (place INTEGER, chunk INTEGER, PRIMARY KEY (place, chunk)) STRICT, WITHOUT ROWID",
)


def renew_plans(connection: sqlite3.Connection) -> None:
    """Make the tables anew, and empty, in a file that has them as no release had them: plans can be computed again."""
    tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
    if "tally" in tables:
        return
    for statement in PLAN_TABLES:
        words = statement.split()
        if words[:2] == ["CREATE", "TABLE"] and words[2] in tables:
            connection.execute(f"DROP TABLE {words[2]}")
    for statement in PLAN_TABLES:
        connection.execute(statement)
