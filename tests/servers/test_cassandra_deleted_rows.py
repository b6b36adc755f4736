"""What comes and goes leaves few deleted rows behind: a real Cassandra that refuses queries over a hundred of them."""

from collections.abc import Callable, Iterator

import pytest
from cassandra.query import SimpleStatement

from ppaas.errors import Unavailable
from ppaas.tasks.records import Task
from storage.cassandra.connection.cluster import LIST_GRACE, LISTS
from storage.cassandra.store import CassandraStore
from storage.people import MapPeople
from storage.records import CloneLogChange, MapTask
from tests.servers.cassandra_server import SMALL, CassandraServer, NodeSize
from tests.servers.jars import Missing
from tests.support.storage.records import clone, plan, robot, token, user

pytestmark = pytest.mark.servers

THRESHOLD = 100
COUNT = THRESHOLD + 20
STRICT = NodeSize(
    SMALL.jvm, SMALL.settings | {"tombstone_warn_threshold": THRESHOLD // 2, "tombstone_failure_threshold": THRESHOLD}
)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[CassandraServer]:
    try:
        made = CassandraServer(tmp_path_factory.mktemp("strict"), STRICT)
    except Missing as error:
        pytest.skip(f"no Cassandra: {error}")
    try:
        made.start()
        yield made
    finally:
        made.stop()


@pytest.fixture
def store(server: CassandraServer) -> Iterator[CassandraStore]:
    opened = CassandraStore(server.url("strict", "?timeout=20"))
    opened.users()
    yield opened
    opened.close()
    server.empty("strict", all_tables=True)


def names(prefix: str = "n") -> list[str]:
    return [f"{prefix}{number:03}" for number in range(COUNT)]


def task(name: str) -> MapTask:
    return MapTask("ann", "house", Task(id=name, kind="go_to", places=((1.0, 2.0, 0.0),)))


ORDERS: list[Callable[[list[str]], list[str]]] = [
    lambda ids: ids,
    lambda ids: ids[::-1],
    lambda ids: ids[::2] + ids[1::2],
]


def test_the_threshold_is_that_of_the_node(store: CassandraStore) -> None:
    for name in names():
        store._session.write("INSERT INTO plans_by_map (map, created, id) VALUES ('house', 1.0, ?)", name)
        store._session.write("DELETE FROM plans_by_map WHERE map = 'house' AND created = 1.0 AND id = ?", name)
    with pytest.raises(Unavailable, match=r"deleted rows.*nodetool compact"):
        store.plans("house")


@pytest.mark.parametrize("order", ORDERS, ids=["as they came", "backwards", "every second first"])
def test_tasks_come_and_go(store: CassandraStore, order: Callable[[list[str]], list[str]]) -> None:
    store.put_task(task("n050x"))
    for name in names():
        store.put_task(task(name))
    for name in order(names()):
        store.remove_task("ann", "house", name)
    assert store.tasks("ann", "house") == [task("n050x")]
    assert store.task_groups() == [("ann", "house")]
    store.put_task(task("n007"))
    assert [one.task.id for one in store.tasks("ann", "house")] == ["n007", "n050x"]
    store.remove_task("ann", "house", "n007")
    store.remove_task("ann", "house", "n050x")
    assert (store.tasks("ann", "house"), store.task_groups()) == ([], [])


def test_robots_with_checkpoints_come_and_go(store: CassandraStore) -> None:
    store.add_user(user("ann"))
    store.put_robot(robot("stays"))
    for name in names():
        store.put_robot(robot(name))
        store.put_urdf("ann", name, b"<robot/>")
        store.save_clone(clone(name))
        store.remove_robot("ann", name)
    assert [one.id for one in store.robots("ann")] == ["stays"]
    store.remove_user("ann")


def test_tokens_expire_and_are_removed(store: CassandraStore) -> None:
    store.add_user(user("ann"))
    store.add_token(token("0" * 64, expires=9e9))
    for number, name in enumerate(names("a")):
        store.add_token(token(name, expires=float(number)))
    assert store.remove_tokens(expired_before=1e9) == COUNT
    for name in names("b"):
        store.add_token(token(name, expires=8e9))
        store.remove_token(name)
    assert [one.hash for one in store.tokens("ann")] == ["0" * 64]
    assert store.remove_tokens(expired_before=1e9) == 0


def test_users_come_and_go(store: CassandraStore) -> None:
    store.put_task(task("other"))
    store.put_people_settings(MapPeople("bob", "house"))
    for name in names():
        store.add_user(user(name))
        store.remove_user(name)
    store.add_user(user("ann"))
    assert [one.id for one in store.users()] == ["ann"]
    assert store.task_groups() == [("ann", "house")]
    assert store.people_of_map("house") == [MapPeople("bob", "house")]


def test_the_plans_of_a_map_are_removed_together(store: CassandraStore) -> None:
    store.add_plan(plan("other", map="yard"))
    store.add_plans([plan(name, created=float(number)) for number, name in enumerate(names())])
    assert store.remove_plans("house") == COUNT
    assert (store.plans("house"), store.plan_maps()) == ([], ["yard"])
    assert store.plan_statistics("house").plans == 0
    store.add_plan(plan("new"))
    assert [one.id for one in store.plans("house")] == ["new"]
    assert store._session.row("SELECT count(*) FROM plans_at_spots")[0] == 2


@pytest.mark.parametrize("at_once", [1, 7])
def test_entries_of_a_log_are_replaced(store: CassandraStore, at_once: int) -> None:
    checkpoint = clone()
    entries = dict.fromkeys(range(0, 2 * COUNT, 2), b"x")
    store.save_clone(checkpoint, CloneLogChange("slam", entries))
    gone = [number for number in entries if number not in (0, 100)]
    for at in range(0, len(gone), at_once):
        store.save_clone(checkpoint, CloneLogChange("slam", {}, gone[at : at + at_once]))
    assert store.clone_log("ann", "tb1", "slam") == [(0, b"x"), (100, b"x")]
    store.save_clone(checkpoint, CloneLogChange("slam", {1000: b"y"}, [0, 100]))
    assert store.clone_log("ann", "tb1", "slam") == [(1000, b"y")]
    assert store.clone_logs("ann", "tb1") == ["slam"]


def test_lists_keep_deleted_rows_for_hours_also_in_earlier_keyspaces(
    store: CassandraStore, server: CassandraServer
) -> None:
    server.execute("strict", f"ALTER TABLE {LISTS[0]} WITH gc_grace_seconds = 864000")
    again = CassandraStore(server.url("strict"))
    query = "SELECT table_name, gc_grace_seconds FROM system_schema.tables WHERE keyspace_name = 'strict'"
    found = dict(tuple(row) for row in again._session._session().execute(SimpleStatement(query)))
    again.close()
    assert {name for name, grace in found.items() if grace == LIST_GRACE} == set(LISTS)
    assert {grace for name, grace in found.items() if name not in LISTS} == {864000}
