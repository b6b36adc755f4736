"""Fixtures of the real servers. Each starts for the first test that needs it, and is shared by all tests of a run."""

import contextlib
import functools
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

import pytest

from tests.servers.jars import Missing

if TYPE_CHECKING:
    from storage.cassandra.connection.session import CassandraSession
    from storage.cassandra.store import CassandraStore
    from storage.hdfs.store import HdfsMapStore
    from tests.servers.cassandra_server import CassandraServer
    from tests.servers.hdfs_server import HdfsServer
    from tests.servers.keycloak_server import KeycloakServer
    from tests.servers.s3_server import S3Server


class Server(Protocol):
    """A server that can be started and stopped."""

    def start(self) -> None: ...
    def stop(self) -> None: ...


S = TypeVar("S", bound=Server)


def _running(kind: Callable[[Path], S], name: str, folder: Path) -> Iterator[S]:
    try:
        server = kind(folder)
    except Missing as error:
        pytest.skip(f"no {name}: {error}")
    try:
        server.start()
        yield server
    finally:
        server.stop()


@pytest.fixture(scope="session")
def cassandra_server(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[CassandraServer]":
    """Return a running Cassandra, or skip if it is not installed; a test that kills it starts it again."""
    from tests.servers.cassandra_server import CassandraServer

    yield from _running(CassandraServer, "Cassandra", tmp_path_factory.mktemp("cassandra"))


@pytest.fixture(scope="module")
def cassandra_connections(cassandra_server: "CassandraServer") -> "Iterator[CassandraSession]":
    """Return connections that the tests of a module share: to open them takes longer than most of the tests."""
    from storage.cassandra.connection.address import parse_address
    from storage.cassandra.connection.session import CassandraSession

    session = CassandraSession(parse_address(cassandra_server.url("contracts")))
    yield session
    session.close()


@pytest.fixture
def cassandra_store(
    cassandra_server: "CassandraServer", cassandra_connections: "CassandraSession"
) -> "Iterator[CassandraStore]":
    """Return an empty store in Cassandra."""
    from storage.cassandra.store import CassandraStore

    store = CassandraStore(cassandra_server.url("contracts"))
    store._session = cassandra_connections
    yield store
    cassandra_server.empty("contracts")


@pytest.fixture(scope="session")
def hdfs_servers(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[Callable[[str | None], HdfsServer]]":
    """Return a function that returns a running HDFS of a version (default: that of the image), one of each."""
    from tests.servers.hdfs_server import HdfsServer

    with contextlib.ExitStack() as stack:

        @functools.cache
        def running(version: str | None) -> HdfsServer:
            folder = tmp_path_factory.mktemp("hdfs")
            kind = functools.partial(HdfsServer, version=version)
            return stack.enter_context(contextlib.contextmanager(_running)(kind, "HDFS", folder))

        yield running


@pytest.fixture
def hdfs_server(request: pytest.FixtureRequest, hdfs_servers: "Callable[[str | None], HdfsServer]") -> "HdfsServer":
    """Return a running HDFS, of the version that tests may be parametrized with, or skip if it is not installed.

    A test that kills it starts it again.
    """
    return hdfs_servers(getattr(request, "param", None))


@pytest.fixture
def hdfs_store(hdfs_server: "HdfsServer") -> "HdfsMapStore":
    """Return an empty map store in HDFS."""
    return empty_hdfs_store(hdfs_server)


def empty_hdfs_store(server: "HdfsServer") -> "HdfsMapStore":
    """Return an empty map store in a running HDFS."""
    from storage.hdfs.store import HdfsMapStore

    return HdfsMapStore(server.url(f"maps/{uuid.uuid4().hex}"))


@pytest.fixture(scope="session")
def s3_server(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[S3Server]":
    """Return a running server of S3, or skip if it is not installed."""
    from tests.servers.s3_server import S3Server

    yield from _running(S3Server, "S3", tmp_path_factory.mktemp("s3"))


@pytest.fixture(scope="session")
def keycloak_server(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[KeycloakServer]":
    """Return a running Keycloak, or skip if it is not installed."""
    from tests.servers.keycloak_server import KeycloakServer

    yield from _running(KeycloakServer, "Keycloak", tmp_path_factory.mktemp("keycloak"))
