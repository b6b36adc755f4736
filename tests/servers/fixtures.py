"""The real servers, each started when the first test asks for it, and shared by all of a run."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.servers.jars import Missing

if TYPE_CHECKING:
    from tests.servers.cassandra_server import CassandraServer


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
