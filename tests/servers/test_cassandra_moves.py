"""A Cassandra node comes back under another address, to which its host name then leads."""

import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ppaas.errors import Unavailable
from storage.cassandra.store import CassandraStore
from storage.store_and_forward.plan_outbox import PlanOutbox
from storage.store_and_forward.store import StoreAndForward
from tests.servers.cassandra_server import PASSWORD, CassandraServer
from tests.servers.jars import Missing
from tests.support.storage.records import plan, user
from tests.support.waiting import wait_until

pytestmark = pytest.mark.servers

NAME, BEFORE, AFTER = "cassandra-host", "127.0.0.1", "127.0.0.2"


@pytest.fixture
def server(tmp_path: Path) -> Iterator[CassandraServer]:
    try:
        made = CassandraServer(tmp_path)
    except Missing as error:
        pytest.skip(f"no Cassandra: {error}")
    try:
        made.start()
        yield made
    finally:
        made.stop()


def test_a_node_under_another_address_is_found_by_its_name(
    server: CassandraServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    resolve, address = socket.getaddrinfo, [BEFORE]

    def by_name(host: Any, *arguments: Any, **options: Any) -> Any:
        return resolve(address[0] if host == NAME else host, *arguments, **options)

    monkeypatch.setattr(socket, "getaddrinfo", by_name)
    store = CassandraStore(f"cassandra://cassandra:{PASSWORD}@{NAME}:{server.port}/moved?timeout=20")
    with_outbox = StoreAndForward(store, PlanOutbox(tmp_path / "outbox"))
    try:
        store.add_user(user("ann"))
        server.stop()
        config = tmp_path / "cassandra.yaml"
        config.write_text(config.read_text().replace(BEFORE, AFTER))
        with_outbox.add_plan(plan("waiting"))
        with pytest.raises(Unavailable, match="start Cassandra"):
            store.users()
        server.launch()
        address[0] = AFTER
        wait_until(lambda: names(store) == ["ann"])
        assert store.user("ann") == user("ann"), "statements that were prepared before are prepared again"
        store.add_user(user("bob"))
        assert names(store) == ["ann", "bob"]
        wait_until(lambda: [one.id for one in store.plans("house")] == ["waiting"])
    finally:
        with_outbox.close()


def names(store: CassandraStore) -> list[str]:
    try:
        return [one.id for one in store.users()]
    except Unavailable:
        return []
