"""The tables in Cassandra.

A row is what is looked for, in columns, and the record beside it as bytes (``storage.encoding``). No table is read
whole: what is listed in order lies in one partition, in that order.

There are no transactions over several tables, so what must go together hangs on one row of ``users``. It has two
numbers: robots, checkpoints and the like of a user lie under the user's ``generation``, tokens carry an ``epoch``, and
whatever is not of the present number is as good as not there. To remove a user raises both, to change a password the
epoch: at once, whenever the process dies. What lies under old numbers is swept away after that.

A plan lies whole in ``plans_at_spots``, and is there from the moment when that row is: ``plans`` and ``plans_by_map``
are written before and removed after it, and what they name may be gone. Only a plan that was replaced lies whole in
``plans`` too, where one of two who replace it wins. Of the plans at each spot ``plan_fronts`` has a few once more.
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
    "urdfs": """user text, generation int, robot text, id uuid, data blob,
                PRIMARY KEY ((user, generation, robot), id)""",
    "clones": "user text, generation int, robot text, record blob, PRIMARY KEY ((user, generation), robot)",
    "history": """map text, version text, planner text, bucket int, record blob,
                  PRIMARY KEY (map, version, planner, bucket)""",
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
    "links": "shard tinyint, link text, record blob, PRIMARY KEY (shard, link)",
}


def statements() -> dict[str, str]:
    """Return by its name what makes each table, if it is not there."""
    return {name: f"CREATE TABLE IF NOT EXISTS {name} ({columns})" for name, columns in _TABLES.items()}
