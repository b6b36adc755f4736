"""Tests that need a real Cassandra: agreement with other stores, concurrent writers, interrupted writes."""

import contextlib
import itertools
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

from ppaas.errors import Conflict, InvalidInput, NotFound, Unavailable
from ppaas.geometry import poses_along
from robots import cli
from storage.cassandra.connection.cluster import VERSION
from storage.cassandra.plans.endpoint_cells import ends_of
from storage.cassandra.store import CassandraStore
from storage.memory.store import MemoryStore
from storage.plan_query import PlanStoreQuery
from storage.ports import Store
from storage.records import PlanRecord
from storage.sharing_records import ProvidedIdentity
from tests.contracts.test_plans_in_any_order import PlansInAnyOrder
from tests.contracts.test_stores_agree import StoresAgree
from tests.servers.cassandra_server import CassandraServer
from tests.support.budget import examples
from tests.support.storage.records import plan, robot, token, user

pytestmark = pytest.mark.servers


@pytest.fixture(autouse=True)
def server(cassandra_server: CassandraServer) -> CassandraServer:
    CassandraAgrees.server = CassandraInAnyOrder.server = cassandra_server
    return cassandra_server


@pytest.fixture
def stores(server: CassandraServer) -> Iterator[list[CassandraStore]]:
    """Return two stores of one keyspace, in place of two processes."""
    opened = [CassandraStore(server.url("contracts")) for _ in range(2)]
    yield opened
    for store in opened:
        store.close()
    server.empty("contracts")


class CassandraAgrees(StoresAgree):
    """Cassandra compared with the store in memory."""

    server: CassandraServer

    def __init__(self) -> None:
        super().__init__()
        for store in self.stores:
            store.close()
        self.stores = (MemoryStore(), CassandraStore(self.server.url("agree")))  # type: ignore[assignment]

    def teardown(self) -> None:
        super().teardown()
        self.server.empty("agree")


TestCassandraAgrees = CassandraAgrees.TestCase
TestCassandraAgrees.settings = settings(max_examples=examples(8), stateful_step_count=30)


def test_users_from_before_the_index_of_identities_are_found(stores: list[CassandraStore]) -> None:
    one, other = stores
    identity = ProvidedIdentity("https://login.example", "id of ann")
    one.add_user(user("ann", identity=identity))
    one.add_user(user("bob"))
    one._session.write("TRUNCATE users_by_identity")
    assert other.user_with_identity(identity).id == "ann"
    one._session.write("DELETE FROM users_by_identity WHERE issuer = '-' AND subject = '-'")
    assert other.user_with_identity(identity).id == "ann", "they are not read again"


class CassandraInAnyOrder(PlansInAnyOrder):
    """Cassandra compared with the store in memory; its statistics of segments are exact after a sweep."""

    server: CassandraServer

    def __init__(self) -> None:
        super().__init__()
        for store in self.stores:
            store.close()
        self.stores = (MemoryStore(), CassandraStore(self.server.url("agree")))

    def contents(self, store: Store) -> tuple[Any, ...]:
        if isinstance(store, CassandraStore):
            before = store.plan_statistics()
            store.sweep_entries()
            after = store.plan_statistics()
            assert (before.plans, before.waypoints) == (after.plans, after.waypoints)
        return super().contents(store)

    def teardown(self) -> None:
        super().teardown()
        self.server.empty("agree")


TestCassandraInAnyOrder = CassandraInAnyOrder.TestCase
TestCassandraInAnyOrder.settings = settings(max_examples=examples(5), stateful_step_count=15)


# -- concurrent writers ------------------------------------------------------------------------------------------------


def test_concurrent_changes_of_a_robot_lose_nothing(stores: list[CassandraStore]) -> None:
    stores[0].put_robot(robot("tb1", parameters={"count": 0}))

    def count_up(store: CassandraStore) -> None:
        for _ in range(20):
            while True:
                seen = store.robot("ann", "tb1")
                changed = robot("tb1", parameters={"count": seen.parameters["count"] + 1})
                try:
                    store.put_robot(changed, instead_of=seen)
                    break
                except Conflict:
                    continue

    with ThreadPoolExecutor(2) as threads:
        list(threads.map(count_up, stores))
    assert stores[0].robot("ann", "tb1").parameters == {"count": 40}


def test_one_of_two_concurrent_replacements_of_a_plan_succeeds(stores: list[CassandraStore]) -> None:
    before = plan("p1", cost=0.0)
    stores[0].add_plan(before)
    for number in range(1, 11):

        def replace(index: int, number: int = number, before: PlanRecord = before) -> bool:
            try:
                stores[index].replace_plan(plan("p1", cost=number + index / 2.0), instead_of=before)
            except Conflict:
                return False
            return True

        with ThreadPoolExecutor(2) as threads:
            won = list(threads.map(replace, range(2)))
        assert won.count(True) == 1
        before = plan("p1", cost=number + won.index(True) / 2.0)
        assert stores[1].plan("p1") == before
        assert [one.cost for one in stores[0].plans("house")] == [before.cost]


def test_tokens_added_while_their_user_is_removed_are_invalid(stores: list[CassandraStore]) -> None:
    one, other = stores
    one.add_user(user("ann"))
    numbers = itertools.count()

    def log_in(_: int) -> None:
        for _ in range(30):
            try:
                one.add_token(token(f"{next(numbers):064}"))
            except NotFound:
                return

    with ThreadPoolExecutor(2) as threads:
        giving = [threads.submit(log_in, number) for number in range(2)]
        other.remove_user("ann")
        for done in giving:
            done.result()
    other.add_user(user("ann"))
    assert other.tokens("ann") == []
    for number in range(next(numbers)):
        with pytest.raises(NotFound):
            one.token(f"{number:064}")


# -- entries -----------------------------------------------------------------------------------------------------------


def path(plan_id: str, seed: int, count: int = 400) -> PlanRecord:
    """Return a plan along a random walk."""
    steps = np.random.default_rng(seed).integers(-1, 2, (count, 2))
    return plan(plan_id, poses=poses_along(np.cumsum(steps, axis=0) * 0.05, 0.0).tobytes(), version="v1")


def test_shared_segments_are_stored_once_until_no_plan_refers_to_them(stores: list[CassandraStore]) -> None:
    one, other = stores
    one.add_plan(path("a", seed=1))
    alone = one.plan_statistics()
    other.add_plan(path("b", seed=1))
    both = one.plan_statistics()
    assert (both.plans, both.waypoints, both.entries) == (2, 2 * alone.waypoints, alone.entries)
    assert {part.plans for part in one.plan_parts("a")} == {2}
    one.remove_plan("a")
    assert one.sweep_entries(grace=0.0) == 0
    assert other.plan("b") == path("b", seed=1)


def test_unreferenced_segments_are_swept_after_the_grace_time(stores: list[CassandraStore]) -> None:
    one, other = stores
    one.add_plans([path("a", seed=1), path("b", seed=2)])
    parts = {part.entry for part in one.plan_parts("a")} - {part.entry for part in one.plan_parts("b")}
    one.remove_plan("a")
    assert other.sweep_entries() == 0, "all were written a moment ago"
    assert other.sweep_entries(grace=0.0) == len(parts)
    assert other.plan("b") == path("b", seed=2)
    with pytest.raises(NotFound):
        other.plan("a")


def test_a_recipe_too_long_for_a_row_is_split_into_entries(stores: list[CassandraStore]) -> None:
    one, other = stores
    long = path("long", seed=3, count=20_000)
    one.add_plan(long)
    assert other.plan("long") == long
    assert len(other.plan_parts("long")) > 256
    assert other.sweep_entries(grace=0.0) == 0
    assert other.plan_statistics().waypoints == 20_000


def test_plans_are_found_behind_many_shorter_ones_just_too_far_away(stores: list[CassandraStore]) -> None:
    def straight(plan_id: str, off: float, length: float) -> PlanRecord:
        poses = poses_along(np.array([[10.5 + off, 20.5 + off], [30.5, 20.5]]), 0.0)
        return plan(plan_id, poses=poses.tobytes(), length=length)

    one, other = stores
    one.add_plans([straight(f"off{n:03}", 0.09, 1.0 + n // 40) for n in range(500)])
    one.add_plans([straight(f"at{n}", 0.0, 20.0 - n // 2) for n in range(6)])
    search = PlanStoreQuery("house", "v", (10.5, 20.5), (30.5, 20.5), 0.1)
    assert [head.id for head in other.find_plans(search, limit=4)] == ["at4", "at5", "at2", "at3"]
    assert [head.id for head in other.find_plans(search)] == ["at4", "at5", "at2", "at3", "at0", "at1"]
    one.add_plans([straight(f"also{n:03}", 0.02, 1.0) for n in range(200)])
    assert [head.id for head in other.find_plans(search, limit=70)] == [f"also{n:03}" for n in range(70)]


# -- plans that are alike ----------------------------------------------------------------------------------------------

HERE = PlanStoreQuery("house", "v", *ends_of(plan("p")), 0.1)


def alike(first: int, last: int) -> list[PlanRecord]:
    return [plan(f"p{number:02}") for number in range(first, last)]


def rows_in_front(store: CassandraStore) -> list[str]:
    return [row.id for row in store._session.rows("SELECT id FROM plan_fronts")]


def test_all_plans_of_one_cell_are_found_also_after_removals(
    stores: list[CassandraStore],
) -> None:
    one, other = stores
    for first in range(0, 30, 3):
        one.add_plans(alike(first, first + 3))
    assert rows_in_front(other) == ["", "p00"]
    assert [head.id for head in other.find_plans(HERE, limit=40)] == [f"p{n:02}" for n in range(30)]
    assert len(other.find_plans(HERE, limit=3)) == 3
    for number in range(4):
        other.remove_plan(f"p{number:02}")
    assert rows_in_front(other) == [""]
    other.add_plan(plan("q"))
    assert [head.id for head in one.find_plans(HERE, limit=40)] == [*(f"p{n:02}" for n in range(4, 30)), "q"]
    assert one.remove_plans("house") == 27
    assert one.find_plans(HERE) == []
    one.add_plan(plan("r"))
    assert [head.id for head in other.find_plans(HERE)] == ["r"]


def test_a_plan_replaced_in_a_full_cell_is_found_in_its_new_form(stores: list[CassandraStore]) -> None:
    one, other = stores
    one.add_plans(alike(0, 6))
    for name in ("p00", "p05"):
        one.replace_plan(plan(name, cost=7.0), instead_of=plan(name))
    assert {head.id: head.cost for head in other.find_plans(HERE)} == dict.fromkeys(
        (f"p{n:02}" for n in range(6)), 118.5
    ) | {"p00": 7.0, "p05": 7.0}
    one.replace_plan(plan("p00", length=9.0), instead_of=plan("p00", cost=7.0))
    assert [head.id for head in other.find_plans(HERE)] == ["p01", "p02", "p03", "p04", "p05", "p00"]


def test_a_sweep_leaves_a_few_representatives_and_marks_missed_cells(stores: list[CassandraStore]) -> None:
    one, other = stores
    one.add_plans(alike(0, 6))
    other.add_plans(alike(6, 12))
    assert rows_in_front(one) == ["", "p00", "p06"]
    one.sweep_entries()
    assert rows_in_front(one) == ["", "p00", "p06"], "they were written a moment ago"
    one.sweep_entries(grace=0.0)
    assert rows_in_front(one) == ["", "p00"]
    assert len(other.find_plans(HERE)) == 12
    one._session.write("TRUNCATE plan_fronts")
    assert other.find_plans(HERE) == []
    other.sweep_entries()
    assert len(one.find_plans(HERE)) == 12
    one.remove_plans("house")
    one.sweep_entries(grace=0.0)
    assert rows_in_front(one) == []


# -- interrupted writes ------------------------------------------------------------------------------------------------


def found(store: CassandraStore, record: PlanRecord) -> list[str]:
    """Return the ids of the plans that a search finds by the ends of a plan."""
    search = PlanStoreQuery(record.map, record.version, *ends_of(record), 0.1)
    return [head.id for head in store.find_plans(search)]


@contextlib.contextmanager
def cut_off(store: CassandraStore, name: str, after: int) -> Iterator[None]:
    """Make a method that writes fail after a number of calls, as if the process were killed then."""
    session, calls = store._session, itertools.count()
    write = getattr(session, name)

    def fail(*arguments: Any) -> None:
        if next(calls) == after:
            raise Unavailable("cut off")
        write(*arguments)

    setattr(session, name, fail)
    with pytest.raises(Unavailable, match="cut off"):
        yield
    delattr(session, name)


def test_plans_named_but_not_written_are_not_found(stores: list[CassandraStore]) -> None:
    one, other = stores
    plans = [path("a", seed=1), path("b", seed=2)]
    with cut_off(one, "write_unlogged", after=3):  # segments, contexts, and names of the plans
        one.add_plans(plans)
    assert (other.plans("house"), other.plan_maps(), other.whole_plans(["a", "b"]), found(other, plans[0])) == (
        [], [], {}, [],
    )  # fmt: skip
    with pytest.raises(NotFound):
        other.plan("a")
    with pytest.raises(NotFound):
        other.remove_plan("a")
    assert other.plan_statistics().plans == 0
    assert other.add_plans(plans) == 2
    assert one.whole_plans(["a", "b"]) == {"a": plans[0], "b": plans[1]}
    assert (one.plan_maps(), found(one, plans[0]), one.plan_statistics().plans) == (["house"], ["a"], 2)
    assert one.add_plans(plans) == 0


def test_a_sweep_completes_an_interrupted_replacement(stores: list[CassandraStore]) -> None:
    one, other = stores
    old, new = path("a", seed=1), path("a", seed=2)
    one.add_plan(old)
    with cut_off(one, "write_batches", after=0):
        one.replace_plan(new, instead_of=old)
    assert other.plan("a") == new
    assert (found(other, old), found(other, new)) == (["a"], []), "it is still stored at its old ends"
    other.sweep_entries(grace=0.0)
    assert (found(one, old), found(one, new), one.plan("a")) == ([], ["a"], new)
    assert one.plan_statistics().plans == 1
    one.remove_plan("a")
    other.sweep_entries(grace=0.0)
    assert (found(other, new), other.plans("house")) == ([], [])


def test_a_plan_without_names_is_swept(stores: list[CassandraStore], server: CassandraServer) -> None:
    one, other = stores
    one.add_plans([path("a", seed=1), path("b", seed=2)])
    server.execute("contracts", "DELETE FROM plans WHERE id = 'a'")
    assert found(other, path("a", seed=1)) == ["a"]
    other.sweep_entries()
    assert found(other, path("a", seed=1)) == ["a"], "a concurrent removal or addition has the grace time"
    other.sweep_entries(grace=0.0)
    assert (found(one, path("a", seed=1)), found(one, path("b", seed=2))) == ([], ["b"])


# -- unreachable nodes -------------------------------------------------------------------------------------------------


def test_a_wrong_password_is_reported_without_the_password(server: CassandraServer) -> None:
    store = CassandraStore(server.url("contracts").replace("cassandra:cassandra@", "cassandra:wrong-secret@"))
    with pytest.raises(Unavailable, match="password is wrong") as caught:
        store.users()
    assert "secret" not in str(caught.value)
    store.close()


def test_an_unreachable_node_is_reported(server: CassandraServer) -> None:
    store = CassandraStore(f"cassandra://127.0.0.1:{server.port + 1}/ppaas?timeout=1")
    for _ in range(3):
        with pytest.raises(Unavailable, match="start Cassandra"):
            store.users()
    store.close()
    with pytest.raises(Unavailable, match="closed"):
        store.users()


@pytest.mark.parametrize(("version", "error"), [(99, "newer release"), (1, "before the first release.*migrate")])
def test_a_keyspace_of_another_release_is_refused(
    version: int, error: str, stores: list[CassandraStore], server: CassandraServer
) -> None:
    stores[0].users()
    server.execute("contracts", f"UPDATE schema_version SET version = {version} WHERE id = 0")
    other = CassandraStore(server.url("contracts"))
    with pytest.raises(Unavailable, match=error):
        other.users()
    other.close()
    server.execute("contracts", f"UPDATE schema_version SET version = {VERSION} WHERE id = 0")


def test_tls_connections_verify_the_certificate_of_a_node(server: CassandraServer) -> None:
    verified = CassandraStore(server.url("contracts", f"?tls=yes&ca={server.certificate}"))
    assert verified.users() == []
    verified.close()
    unverified = CassandraStore(server.url("contracts", "?tls=yes&timeout=2"))
    with pytest.raises(Unavailable, match=r"(?i)certificate"):
        unverified.users()
    unverified.close()


@pytest.mark.parametrize("name", ["x'; DROP TABLE users; --", "Upper", "", "a-b", "x" * 49])
def test_an_invalid_keyspace_name_is_refused(name: str) -> None:
    with pytest.raises(InvalidInput, match="keyspace"):
        CassandraStore(f"cassandra://db/{name}")


def test_the_sweep_command_sweeps_a_store(stores: list[CassandraStore], server: CassandraServer) -> None:
    stores[0].add_plan(path("a", seed=1))
    done = subprocess.run(
        [sys.executable, "-m", cli.__name__, "store", "sweep", server.url("contracts")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "0 segments removed\n"), done.stderr


def test_a_plan_with_large_parameters_is_stored(stores: list[CassandraStore]) -> None:
    long = path("long", seed=1)
    large = plan("large", poses=long.poses, version="v1", parameters={"much": "x" * 60_000})
    stores[0].add_plans([long, large, path("other", seed=2)])
    assert stores[1].plan("large") == large
    assert len(stores[1].plans("house")) == 3
