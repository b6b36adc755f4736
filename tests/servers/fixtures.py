"""The real servers, each started when the first test asks for it, and shared by all of a run."""

import uuid
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.servers.jars import Missing

if TYPE_CHECKING:
    from storage.cassandra import CassandraStore
    from storage.hdfs import HdfsMapStore
    from tests.servers.cassandra_server import CassandraServer
    from tests.servers.hdfs_server import HdfsServer


@pytest.fixture(scope="session")
def cassandra_server(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[CassandraServer]":
    """Return a running Cassandra, or skip where it cannot be had; whoever kills it starts it again."""
    from tests.servers.cassandra_server import CassandraServer

    try:
        server = CassandraServer(tmp_path_factory.mktemp("cassandra"))
    except Missing as error:
        pytest.skip(f"no Cassandra: {error}")
    try:
        server.start()
        yield server
    finally:
        server.stop()


@pytest.fixture
def cassandra_store(cassandra_server: "CassandraServer") -> "Iterator[CassandraStore]":
    """Return an empty store in Cassandra."""
    from storage.cassandra import CassandraStore

    store = CassandraStore(cassandra_server.url("contracts"))
    yield store
    store.close()
    cassandra_server.empty("contracts")


@pytest.fixture(scope="session")
def hdfs_server(tmp_path_factory: pytest.TempPathFactory) -> "Iterator[HdfsServer]":
    """Return a running HDFS, or skip where it cannot be had; whoever kills it starts it again."""
    from tests.servers.hdfs_server import HdfsServer

    try:
        server = HdfsServer(tmp_path_factory.mktemp("hdfs"))
    except Missing as error:
        pytest.skip(f"no HDFS: {error}")
    try:
        server.start()
        yield server
    finally:
        server.stop()


@pytest.fixture
def hdfs_store(hdfs_server: "HdfsServer") -> "HdfsMapStore":
    """Return an empty store of maps in HDFS."""
    from storage.hdfs import HdfsMapStore

    return HdfsMapStore(hdfs_server.url(f"maps/{uuid.uuid4().hex}"))
