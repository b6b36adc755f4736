"""Fixtures of the real servers. Each starts for the first test that needs it, and is shared by all tests of a run."""

import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TypeVar

import pytest

from tests.servers.jars import Missing

if TYPE_CHECKING:
    from storage.cassandra.store import CassandraStore
    from storage.hdfs.store import HdfsMapStore
    from tests.servers.cassandra_server import CassandraServer
    from tests.servers.hdfs_server import HdfsServer


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


@pytest.fixture
def cassandra_store(cassandra_server: "CassandraServer") -> "Iterator[CassandraStore]":
    """Return an empty store in Cassandra."""
    from storage.cassandra.store import CassandraStore

    store = CassandraStore(cassandra_server.url("contracts"))
    yield store
    store.close()
    cassandra_server.empty("contracts")


@pytest.fixture(scope="session")
def hdfs_server(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[HdfsServer]":
    """Return a running HDFS, or skip if it is not installed; a test that kills it starts it again."""
    from tests.servers.hdfs_server import HdfsServer

    yield from _running(HdfsServer, "HDFS", tmp_path_factory.mktemp("hdfs"))


@pytest.fixture
def hdfs_store(hdfs_server: "HdfsServer") -> "HdfsMapStore":
    """Return an empty map store in HDFS."""
    from storage.hdfs.store import HdfsMapStore

    return HdfsMapStore(hdfs_server.url(f"maps/{uuid.uuid4().hex}"))
