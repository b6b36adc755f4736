"""Tables in Cassandra.

A row has the keys in columns and the record as bytes (``storage.encoding``). No request scans a table: each sorted list
is one partition with a clustering order.

Cassandra has no transactions over several tables, so atomic changes of a user depend on one row of ``users``. It has
two numbers. Robots and checkpoints are stored under the user's ``generation``, and tokens have an ``epoch``; rows with
other numbers are treated as missing. Removing a user increases both numbers, and changing the password increases the
epoch, in one conditional write. Rows of old numbers are deleted afterwards.

The rows of ``robots_by_grantee`` are written before the record of a robot that is shared, and removed after it, so
they may name a robot that is not shared any more.

Deleted rows stay as tombstones for a while, and a query that meets too many of them fails. So what comes and goes is
removed by ranges or by partitions (``storage.cassandra.sorted_rows``), or is in one of the ``LISTS``, whose tombstones
are kept for hours only.

The whole plan is a row of ``plans_at_spots``, and exists if that row exists. The rows that name it, in ``plans`` (by
id) and ``plans_by_map``, are written before it and deleted after it, so they may name a plan that does not exist. Only
a plan that was replaced is also stored whole in ``plans``, so that a conditional write decides between concurrent
replacements. A *cell* of the index is a value of (bucket, spot); ``plan_fronts`` repeats a few representatives of the
plans in each cell, and ``plans_by_square`` lists plans by the cells of the map that they touch.
"""

VERSION = 3

_TABLES = {
    "schema_version": "id tinyint PRIMARY KEY, version int",
    "users": """shard tinyint, id text, record blob, generation int, epoch int, kept_token text,
                PRIMARY KEY (shard, id)""",
    "tokens": "hash text PRIMARY KEY, user text, epoch int, expires double, record blob",
    "tokens_by_user": "user text, hash text, PRIMARY KEY (user, hash)",
    "tokens_by_expiry": "shard tinyint, expires double, hash text, PRIMARY KEY (shard, expires, hash)",
    "robots": """user text, generation int, id text, record blob, urdf uuid,
                 PRIMARY KEY ((user, generation), id)""",
    "robots_by_grantee": "grantee text, user text, robot text, PRIMARY KEY (grantee, user, robot)",
    "urdfs": """user text, generation int, robot text, id uuid, data blob,
                PRIMARY KEY ((user, generation, robot), id)""",
    "clones": "user text, generation int, robot text, record blob, PRIMARY KEY ((user, generation), robot)",
    "clone_logs": """user text, generation int, robot text, log text, number bigint, data blob,
                     PRIMARY KEY ((user, generation, robot), log, number)""",
    "history": """map text, version text, planner text, bucket int, record blob,
                  PRIMARY KEY (map, version, planner, bucket)""",
    "people": "map text, user text, generation int, record blob, PRIMARY KEY (map, user, generation)",
    "people_counts": """map text, user text, generation int, hour bigint, zone text, people int,
                        PRIMARY KEY ((map, user, generation), hour, zone)""",
    "plans": "id text PRIMARY KEY, lead blob, head blob, recipe blob",
    "plan_entries": "id blob PRIMARY KEY, data blob",
    "plan_entry_uses": "id blob PRIMARY KEY, plans int",
    "plan_sums": "map text, writer uuid, record blob, PRIMARY KEY (map, writer)",
    "plans_by_map": """map text, created double, id text, PRIMARY KEY (map, created, id))
                       WITH CLUSTERING ORDER BY (created DESC, id DESC""",
    "plans_at_spots": "bucket blob, spot bigint, id text, head blob, recipe blob, PRIMARY KEY (bucket, spot, id)",
    "plan_fronts": "bucket blob, spot bigint, id text, head blob, PRIMARY KEY (bucket, spot, id)",
    "plans_by_square": """scope blob, x bigint, y bigint, created double, id text,
                          PRIMARY KEY ((scope, x, y), created, id)) WITH CLUSTERING ORDER BY (created DESC, id ASC""",
    "tasks": """map text, user text, generation int, id text, record blob,
                PRIMARY KEY (map, user, generation, id)""",
    "leases": "name text PRIMARY KEY, holder text, epoch bigint, beat bigint",
    "links": "shard tinyint, link text, record blob, PRIMARY KEY (shard, link)",
}

LISTS = (
    *("tokens_by_user", "tokens_by_expiry", "robots_by_grantee"),
    *("plans_by_map", "plans_at_spots", "plan_fronts", "plans_by_square"),
)
"""Tables whose rows name something that is stored elsewhere. A row that comes back is skipped, or swept, since what it
names is gone. So their deleted rows need not be kept for ten days, in which too many for a query could gather."""

LIST_GRACE = 6 * 3600
"""Time for which deleted rows of these tables are kept [s]: twice the time for which Cassandra keeps hints."""


def statements() -> dict[str, str]:
    """Return the CREATE TABLE statement of each table, by its name."""
    return {name: f"CREATE TABLE IF NOT EXISTS {name} ({columns}){_options(name)}" for name, columns in _TABLES.items()}


def _options(table: str) -> str:
    if table not in LISTS:
        return ""
    return f" {'AND' if ' WITH ' in _TABLES[table] else 'WITH'} gc_grace_seconds = {LIST_GRACE}"
