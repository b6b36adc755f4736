"""Connecting to Cassandra: the keyspace and its tables are made if they are not there."""

import logging
import ssl
from collections import namedtuple
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from cassandra import ConsistencyLevel
from cassandra.auth import PlainTextAuthProvider
from cassandra.cluster import EXEC_PROFILE_DEFAULT, Cluster, ExecutionProfile, ResultSet, Session
from cassandra.policies import ConstantReconnectionPolicy, DCAwareRoundRobinPolicy, TokenAwarePolicy

from ppaas.errors import InvalidInput, Unavailable
from storage.cassandra.connection.address import CassandraAddress, Tls
from storage.cassandra.connection.schema import VERSION, statements

logging.getLogger("cassandra").setLevel(logging.CRITICAL)  # what it would tell, we raise

RECONNECT = 0.5
"""Seconds between two tries to reach a node that is away."""

PROTOCOL = 5
"""Of Cassandra 4.0 and later."""


def connect(address: CassandraAddress) -> Session:
    """Return a session with the keyspace of an address, whose tables are there.

    Raises
    ------
    Unavailable
        The keyspace was made by a newer release, or before the first.
    Exception
        As the driver raises.
    """
    cluster = cluster_of(address)
    try:
        session = cluster.connect()
        session.use_client_timestamp = False  # those that ask what was there get the server's: one clock for all
        _make_keyspace(cluster, session, address)
        _check_version(session, address)
    except BaseException:
        cluster.shutdown()
        raise
    return session


def is_applied(result: ResultSet) -> bool:
    """Tell whether what was written under a condition was: the first column of the answer says so."""
    return bool(result.one()[0])


def ssl_context(tls: Tls) -> ssl.SSLContext:
    """Return how TLS is spoken with nodes.

    Raises
    ------
    InvalidInput
        A file is not there, or is not what it should be.
    """
    try:
        context = ssl.create_default_context(cafile=tls.ca)
        context.check_hostname = tls.check_name
        if tls.certificate is not None:
            context.load_cert_chain(tls.certificate, tls.key)
    except OSError as error:  # as ssl.SSLError is
        raise InvalidInput(
            f"TLS with Cassandra: {error}; give files in PEM: ca={tls.ca}, certificate={tls.certificate}, key={tls.key}"
        ) from error
    return context


def cluster_of(address: CassandraAddress) -> Cluster:
    """Return the driver's cluster, which is not connected to yet."""
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
        compression=False,  # most of what is sent are hashes; to pack them took a quarter of what a plan costs here
        execution_profiles={EXEC_PROFILE_DEFAULT: profile},
        reconnection_policy=ConstantReconnectionPolicy(RECONNECT, max_attempts=None),
        connect_timeout=address.timeout,
        control_connection_timeout=address.timeout,
    )


def _named(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[Any]:
    """Return rows as named tuples, as the driver would, which makes a new class for every answer."""
    return list(map(_row_type(tuple(columns))._make, rows))


@lru_cache(256)
def _row_type(columns: tuple[str, ...]) -> Any:
    return namedtuple("Row", [name.strip("[]") for name in columns])


def _make_keyspace(cluster: Cluster, session: Session, address: CassandraAddress) -> None:
    """Make the keyspace and its tables, those that are not there."""
    known = cluster.metadata.keyspaces.get(address.keyspace)
    if known is None:
        copies = dict(address.replication)
        session.execute(f"CREATE KEYSPACE IF NOT EXISTS {address.keyspace} WITH replication = {copies}")
    session.set_keyspace(address.keyspace)
    for table, statement in statements().items():
        if known is None or table not in known.tables:
            session.execute(statement)


def _check_version(session: Session, address: CassandraAddress) -> None:
    first = session.execute("INSERT INTO schema_version (id, version) VALUES (0, %s) IF NOT EXISTS", (VERSION,))
    if is_applied(first):
        return
    version = session.execute("SELECT version FROM schema_version WHERE id = 0").one().version
    if version > VERSION:
        raise Unavailable(f"{address}: written by a newer release (schema {version}): upgrade this one")
    if version < VERSION:
        raise Unavailable(
            f"{address}: written before the first release (schema {version}): have what wrote it copy it to another"
            " kind of store (ppaas store migrate), and that into a new keyspace"
        )
