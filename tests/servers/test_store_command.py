"""``ppaas store`` with a real Cassandra and a real HDFS: all pairs, and mistyped URLs."""

import uuid
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from robots.cli import main
from storage.cassandra.store import CassandraStore
from storage.ports import MapStore, Store
from storage.urls.opening import open_map_store, open_store
from tests.servers.cassandra_server import CassandraServer
from tests.servers.hdfs_server import HdfsServer
from tests.support.storage.records import house, plan, put_map, user

pytestmark = pytest.mark.servers


def closed(store: Store | MapStore) -> None:
    if hasattr(store, "close"):
        store.close()


@pytest.mark.parametrize("pair", ["sqlite to cassandra", "cassandra to sqlite", "cassandra to cassandra"])
def test_stores_with_few_kinds_of_records_are_migrated(
    pair: str, cassandra_server: CassandraServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = uuid.uuid4().hex[:8]
    urls = [
        f"sqlite://{tmp_path / end}" if kind == "sqlite" else cassandra_server.url(f"{end}_{name}")
        for kind, end in zip(pair.split(" to "), ("from", "to"), strict=True)
    ]
    source = open_store(urls[0])
    source.add_user(user("ann"))
    source.close()
    for verb in ("migrate", "check"):
        assert main.main(["store", verb, *urls]) == 0, capsys.readouterr().err
    target = open_store(urls[1])
    assert [one.id for one in target.users()] == ["ann"]
    target.close()


def test_no_keyspace_is_created_by_a_check_or_as_a_source(
    cassandra_server: CassandraServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there, missing = f"sqlite://{tmp_path / 'there'}", cassandra_server.url("mistyped")
    open_store(there).close()
    for command in (["check", there, missing], ["migrate", missing, there], ["sweep", missing]):
        assert main.main(["store", *command]) == 1
        assert "the keyspace does not exist" in capsys.readouterr().err
    with pytest.raises(Exception, match="mistyped"):
        cassandra_server.execute("mistyped", "SELECT * FROM users")


@pytest.mark.parametrize("pair", ["file to hdfs", "hdfs to file", "hdfs to hdfs"])
def test_map_stores_are_migrated_and_never_created_by_a_check(
    pair: str, hdfs_server: HdfsServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = uuid.uuid4().hex[:8]
    urls = [
        f"file://{tmp_path / end}" if kind == "file" else hdfs_server.url(f"{end}-{name}")
        for kind, end in zip(pair.split(" to "), ("from", "to"), strict=True)
    ]
    source = open_map_store(urls[0])
    put_map(source, house())
    closed(source)
    assert main.main(["store", "check", *urls]) == 1
    assert "unknown store" in capsys.readouterr().err
    for verb in ("migrate", "check"):
        assert main.main(["store", verb, *urls]) == 0, capsys.readouterr().err
    assert [head.id for head in open_map_store(urls[1]).maps()] == ["house"]


def test_a_damaged_record_in_cassandra_is_named_and_hides_no_other(
    cassandra_server: CassandraServer, capsys: pytest.CaptureFixture[str]
) -> None:
    keyspace = f"flipped_{uuid.uuid4().hex[:8]}"
    store = CassandraStore(cassandra_server.url(keyspace))
    for name in ("ann", "bob", "eve"):
        store.add_user(user(name))
    store.add_plan(plan("p1"))
    record = bytearray(store._session.row("SELECT record FROM users WHERE shard = 0 AND id = 'bob'").record)
    record[12] ^= 0x55
    cassandra_server.execute(keyspace, f"UPDATE users SET record = 0x{record.hex()} WHERE shard = 0 AND id = 'bob'")
    assert [one.id for one in store.users()] == ["ann", "eve"]
    with pytest.raises(Unavailable, match=r"users/bob is damaged.*restore it"):
        store.user("bob")
    store.close()
    assert main.main(["store", "check", cassandra_server.url(keyspace)]) == 1
    assert "users/bob is damaged" in capsys.readouterr().out
