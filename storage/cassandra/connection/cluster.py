"""Connecting to a Cassandra cluster, and creating the keyspace and its tables."""

import logging
import ssl
from collections import namedtuple
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from cassandra import ConsistencyLevel, Unauthorized
from cassandra.auth import PlainTextAuthProvider
from cassandra.cluster import EXEC_PROFILE_DEFAULT, Cluster, ExecutionProfile, ResultSet, Session
from cassandra.policies import ConstantReconnectionPolicy, DCAwareRoundRobinPolicy, TokenAwarePolicy

from ppaas.errors import InvalidInput
from storage.cassandra.connection.address import CassandraAddress, Tls
from storage.store_errors import unusable

logger = logging.getLogger(__name__)


# Tables in Cassandra.
#
# A row has the keys in columns and the record as bytes (``storage.encoding``). No request scans a table: each sorted
# list is one partition with a clustering order.
#
# Cassandra has no transactions over several tables, so atomic changes of a user depend on one row of ``users``. It
# has two numbers. Robots and checkpoints are stored under the user's ``generation``, and tokens have an ``epoch``;
# rows with other numbers are treated as missing. Removing a user increases both numbers, and changing the password
# increases the epoch, in one conditional write. Rows of old numbers are deleted afterwards.
#
# The rows of ``robots_by_grantee`` are written before the record of a robot that is shared, and removed after it, so
# they may name a robot that is not shared any more; the same holds for ``users_by_identity`` and records of users.
#
# Deleted rows stay as tombstones for a while, and a query that meets too many of them fails. So what comes and goes
# is removed by ranges or by partitions (``storage.cassandra.sorted_rows``), or is in one of the ``LISTS``, whose
# tombstones are kept for hours only.
#
# The whole plan is a row of ``plans_at_spots``, and exists if that row exists. The rows that name it, in ``plans``
# (by id) and ``plans_by_map``, are written before it and deleted after it, so they may name a plan that does not
# exist. Only a plan that was replaced is also stored whole in ``plans``, so that a conditional write decides between
# concurrent replacements. A *cell* of the index is a value of (bucket, spot); ``plan_fronts`` repeats a few
# representatives of the plans in each cell, and ``plans_by_square`` lists plans by the cells of the map that they
# touch.

VERSION = 3

_TABLES = {
    "schema_version": "id tinyint PRIMARY KEY, version int",
    "users": """shard tinyint, id text, record blob, generation int, epoch int, kept_token text,
                PRIMARY KEY (shard, id)""",
    "users_by_identity": "issuer text, subject text, user text, PRIMARY KEY ((issuer, subject), user)",
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
    "buildings": "user text, generation int, id text, record blob, PRIMARY KEY (user, generation, id)",
    "webhooks": "user text, generation int, id text, record blob, PRIMARY KEY (user, generation, id)",
    "webhook_deliveries": """user text, hook text, generation int, id text, record blob,
                             PRIMARY KEY ((user, hook), generation, id)""",
    "leases": "name text PRIMARY KEY, holder text, epoch bigint, beat bigint",
    "links": "shard tinyint, link text, record blob, PRIMARY KEY (shard, link)",
}

LISTS = (
    *("users_by_identity", "tokens_by_user", "tokens_by_expiry", "robots_by_grantee"),
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


logging.getLogger("cassandra").setLevel(logging.CRITICAL)  # its errors are raised, too


RECONNECT = 0.5
"""Time between two attempts to reach a node that is down [s]."""

PROTOCOL = 5
"""Version of the native protocol, supported by Cassandra 4.0 and later."""


def connect(address: CassandraAddress, *, create: bool = True) -> Session:
    """Connect and return a session with the keyspace; create the tables that are missing.

    Parameters
    ----------
    address : CassandraAddress
    create : bool
        Whether to create the keyspace if it is missing.

    Raises
    ------
    Unavailable
        The keyspace was written by a newer release, or before the first release; or it is missing, and is not created.
    Exception
        Errors of the driver.
    """
    cluster = cluster_of(address)
    try:
        session = cluster.connect()
        session.use_client_timestamp = False  # conditional writes use the server's, and all must use one clock
        if not create and address.keyspace not in cluster.metadata.keyspaces:
            raise unusable(address, "the keyspace does not exist: correct the URL, or restore it from a backup")
        _make_keyspace(cluster, session, address)
        _check_version(session, address)
    except BaseException:
        cluster.shutdown()
        raise
    return session


def is_applied(result: ResultSet) -> bool:
    """Return whether a conditional write was applied, as the first column of the result states."""
    return bool(result.one()[0])


def ssl_context(tls: Tls) -> ssl.SSLContext:
    """Return the TLS context for connections to nodes.

    Raises
    ------
    InvalidInput
        A file is missing, or is not a valid PEM file of its kind.
    """
    try:
        context = ssl.create_default_context(cafile=tls.ca)
        context.check_hostname = tls.check_name
        if tls.certificate is not None:
            context.load_cert_chain(tls.certificate, tls.key)
    except OSError as error:  # includes ssl.SSLError
        raise InvalidInput(
            f"TLS settings of Cassandra: {error}; give PEM files: ca={tls.ca}, certificate={tls.certificate}, "
            f"key={tls.key}"
        ) from error
    return context


def cluster_of(address: CassandraAddress) -> Cluster:
    """Return the driver's cluster object, not connected yet."""
    login = None if address.user is None else PlainTextAuthProvider(address.user, address.password)
    profile = ExecutionProfile(
        load_balancing_policy=TokenAwarePolicy(DCAwareRoundRobinPolicy(address.data_centre or "")),
        consistency_level=getattr(ConsistencyLevel, address.consistency.upper()),
        serial_consistency_level=ConsistencyLevel.LOCAL_SERIAL,
        request_timeout=address.timeout,
        row_factory=_named,
    )
    return Cluster(
        address.hosts,
        port=address.port,
        protocol_version=PROTOCOL,
        auth_provider=login,
        ssl_context=None if address.tls is None else ssl_context(address.tls),
        compression=False,  # most bytes are hashes; compressing them took a quarter of the client's time per plan
        execution_profiles={EXEC_PROFILE_DEFAULT: profile},
        reconnection_policy=ConstantReconnectionPolicy(RECONNECT, max_attempts=None),
        connect_timeout=address.timeout,
        control_connection_timeout=address.timeout,
    )


def _named(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[Any]:
    """Return rows as named tuples. The driver's own row factory creates a new class for every result."""
    return list(map(_row_type(tuple(columns))._make, rows))


@lru_cache(256)
def _row_type(columns: tuple[str, ...]) -> Any:
    return namedtuple("Row", [name.strip("[]") for name in columns])


def _make_keyspace(cluster: Cluster, session: Session, address: CassandraAddress) -> None:
    """Create the keyspace and its tables where they are missing."""
    known = cluster.metadata.keyspaces.get(address.keyspace)
    if known is None:
        replication = dict(address.replication)
        session.execute(f"CREATE KEYSPACE IF NOT EXISTS {address.keyspace} WITH replication = {replication}")
    session.set_keyspace(address.keyspace)
    for table, statement in statements().items():
        if known is None or table not in known.tables:
            session.execute(statement)
    for table in LISTS if known is not None else ():
        if table in known.tables and known.tables[table].options.get("gc_grace_seconds") != LIST_GRACE:
            _shorten_grace(session, table)


def _shorten_grace(session: Session, table: str) -> None:
    """Change a table of an earlier release; the log names the permission that is missing."""
    try:
        session.execute(f"ALTER TABLE {table} WITH gc_grace_seconds = {LIST_GRACE}")
    except Unauthorized as error:
        logger.warning("grant ALTER, or run ALTER TABLE %s WITH gc_grace_seconds = %d: %s", table, LIST_GRACE, error)


def _check_version(session: Session, address: CassandraAddress) -> None:
    first = session.execute("INSERT INTO schema_version (id, version) VALUES (0, %s) IF NOT EXISTS", (VERSION,))
    if is_applied(first):
        return
    version = session.execute("SELECT version FROM schema_version WHERE id = 0").one().version
    if version > VERSION:
        raise unusable(address, f"written by a newer release (schema {version}): upgrade this one")
    if version < VERSION:
        raise unusable(
            address,
            f"written before the first release (schema {version}): copy it with the release that wrote it to another "
            "kind of store (ppaas store migrate), and from there with this release to a new keyspace",
        )
