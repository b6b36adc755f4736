"""A keyspace of an earlier release opens in this one, or is refused with advice (``tests/earlier``)."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from cassandra.auth import PlainTextAuthProvider
from cassandra.cluster import Cluster

from ppaas.errors import Unavailable
from robots.client.rest import RestClient
from storage.cassandra.store import CassandraStore
from storage.plan_query import PlanStoreQuery
from tests.servers.cassandra_server import PASSWORD, CassandraServer
from tests.support.cloud.cloud import running_cloud
from tests.support.storage.earlier import ANN_PASSWORD, EARLIER, KEYSPACE, digest, expected, lost, unpack
from tests.support.waiting import until

pytestmark = pytest.mark.servers


@pytest.fixture(params=EARLIER, ids=lambda folder: folder.name)
def earlier(request: pytest.FixtureRequest) -> Path:
    folder: Path = request.param
    return folder


@pytest.fixture
def before(earlier: Path) -> dict[str, Any]:
    data: dict[str, Any] = expected(earlier)["keyspace"]
    return data


@pytest.fixture
def server(cassandra_server: CassandraServer, earlier: Path) -> Iterator[CassandraServer]:
    """Return a server with the keyspace, restored from the statements of a dump."""
    login = PlainTextAuthProvider("cassandra", PASSWORD)
    port = cassandra_server.port
    with Cluster(["127.0.0.1"], port=port, protocol_version=5, auth_provider=login) as cluster:
        session = cluster.connect()
        replication = "{'class': 'SimpleStrategy', 'replication_factor': 1}"
        session.execute(f"CREATE KEYSPACE {KEYSPACE} WITH replication = {replication}")
        session.set_keyspace(KEYSPACE)
        for statement in (earlier / "keyspace.cql").read_text().splitlines():
            session.execute(statement)
        yield cassandra_server
        session.execute(f"DROP KEYSPACE {KEYSPACE}", timeout=60.0)


def test_the_store_contains_all_earlier_records(server: CassandraServer, before: dict[str, Any]) -> None:
    with closing(CassandraStore(server.url(KEYSPACE))) as store:
        assert [user.id for user in store.users()] == ["admin", "ann"]
        assert store.user("ann").limits.robots == before["user"]["limits"]["robots"]
        assert [robot.id for robot in store.robots("ann")] == [robot["id"] for robot in before["robots"]]
        assert b"<robot" in store.urdf("ann", "tb2")
        assert {token.user for token in store.tokens("ann")} == {"ann"}
        assert {"amcl", "move_base"} <= store.clone("ann", "tb1").nodes.keys()
        assert store.history("house")
        plans = store.whole_plans(list(before["plans"]))
        assert {plan_id: digest(plan.poses) for plan_id, plan in plans.items()} == {
            plan_id: plan["poses"] for plan_id, plan in before["plans"].items()
        }
        assert (plans["by-hand"].cost, plans["by-hand"].parameters) == (42.5, {"weight": 2.5})
        for plan_id, plan in plans.items():
            search = PlanStoreQuery(plan.map, plan.version, plan.start[:2], plan.goal[:2], 0.01)
            assert plan_id in [head.id for head in store.find_plans(search)]
        assert store.sweep_entries(grace=0.0) == 0, "segments that plans refer to"
        assert store.plan_statistics("house").plans == len(plans)


async def test_a_cloud_runs_on_the_keyspace_and_sends_queued_plans(
    server: CassandraServer, earlier: Path, before: dict[str, Any], tmp_path: Path
) -> None:
    unpack(earlier, tmp_path)
    (tmp_path / "outbox.sqlite").rename(tmp_path / "data" / "outbox.sqlite")
    # Maps and versions are in the folder, not in the keyspace.
    records = before | {name: expected(earlier)["data"][name] for name in ("maps", "versions")}
    with running_cloud(tmp_path, "--store", server.url(KEYSPACE)) as cloud:
        rest = RestClient(cloud.url)
        await rest.login("ann", ANN_PASSWORD)
        assert await lost(cloud.url, rest, records) == []
    with closing(CassandraStore(server.url(KEYSPACE))) as store:
        waited = expected(earlier)["outbox"]
        await until(lambda: store.whole_plans(list(waited)).keys() == waited.keys())


def test_a_keyspace_of_a_newer_release_is_refused_by_name(server: CassandraServer) -> None:
    server.execute(KEYSPACE, "UPDATE schema_version SET version = 99 WHERE id = 0")
    with (
        closing(CassandraStore(server.url(KEYSPACE))) as store,
        pytest.raises(Unavailable, match=rf"{KEYSPACE}: written by a newer release \(schema 99\): upgrade this one"),
    ):
        store.users()
