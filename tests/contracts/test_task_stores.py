"""The contract of every ``TaskStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from ppaas.tasks.options import After, PlaceHold, Repeat
from ppaas.tasks.records import Task
from storage.ports import Store
from storage.records import MapTask
from tests.support.storage.records import NOT_NAMES, user


def record(name: str = "t1", owner: str = "ann", map_id: str = "house", **fields: object) -> MapTask:
    given = {"kind": "pick_drop", "places": ((1.0, 2.0, 0.1), (3.0, -4.0, 1e-300)), "labels": {"lift": "ja é"}}
    return MapTask(owner, map_id, Task(id=name, **(given | fields)))  # type: ignore[arg-type]


def test_a_task_is_returned_as_it_was_stored(store: Store) -> None:
    task = record(state="active", robot="r", leg=1, attempt=7, reason="Zoë", deadline=0.1 + 0.2, begun=5.0)
    store.put_task(task)
    assert store.task("ann", "house", "t1") == task
    options = record(
        holds=(PlaceHold(confirm=True), None), named_robot="r", weight=0.1, not_before=7.0, preempts=True, holding=8.0,
        after=(After(task="t0", on="ended"),), repeat=Repeat(at=("08:30",), days=("mon",), count=3), confirmed=0, run=2,
        series="t0",
    )  # fmt: skip
    store.put_task(options)
    assert store.task("ann", "house", "t1") == options
    store.put_task(record(state="done"))
    assert store.task("ann", "house", "t1") == record(state="done")


def test_a_task_that_does_not_exist_is_not_found(store: Store) -> None:
    store.put_task(record())
    for key in (("ann", "house", "t2"), ("bob", "house", "t1"), ("ann", "yard", "t1")):
        with pytest.raises(NotFound):
            store.task(*key)
        store.remove_task(*key)
    assert store.tasks("bob", "house") == []


def test_a_task_is_replaced_only_if_nobody_changed_it_first(store: Store) -> None:
    with pytest.raises(Conflict):
        store.put_task(record(state="active"), instead_of=record())
    store.put_task(record())
    store.put_task(record(state="active"), instead_of=record())
    with pytest.raises(Conflict):
        store.put_task(record(state="cancelled"), instead_of=record())
    assert store.task("ann", "house", "t1").task.state == "active"


def test_of_concurrent_changes_one_is_made(store: Store) -> None:
    store.put_task(record())

    def change(number: int) -> bool:
        try:
            store.put_task(record(attempt=number + 1), instead_of=record())
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(4) as threads:
        assert sum(threads.map(change, range(12))) == 1


def test_tasks_are_listed_by_id_and_page_by_page(store: Store) -> None:
    for name in ("t2", "t10", "t1"):
        store.put_task(record(name))
    store.put_task(record("t3", "bob"))
    store.put_task(record("t4", map_id="yard"))
    assert [one.task.id for one in store.tasks("ann", "house")] == ["t1", "t10", "t2"]
    assert store.tasks("ann", "house", after="t1", limit=1) == [record("t10")]
    assert store.tasks("ann", "house", after="t15") == [record("t2")]
    assert store.tasks("ann", "house", limit=0) == []
    assert store.task_groups() == [("ann", "house"), ("ann", "yard"), ("bob", "house")]


def test_removed_tasks_are_gone(store: Store) -> None:
    for name in ("t1", "t2"):
        store.put_task(record(name))
    store.put_task(record(map_id="yard"))
    store.remove_task("ann", "house", "t1")
    assert store.tasks("ann", "house") == [record("t2")]
    store.remove_tasks("house")
    store.remove_tasks("house")
    assert store.task_groups() == [("ann", "yard")]


def test_tasks_of_a_removed_user_are_forgotten(store: Store) -> None:
    store.add_user(user("ann"))
    store.put_task(record())
    store.put_task(record(owner="bob"))
    store.remove_user("ann")
    store.add_user(user("ann"))
    assert store.tasks("ann", "house") == []
    assert store.task_groups() == [("bob", "house")]


def test_a_task_that_makes_no_sense_is_refused(store: Store) -> None:
    for wrong in (record(places=()), record(rounds=2), record(priority=1000), record(deadline=-1.0)):
        with pytest.raises(InvalidInput):
            store.put_task(wrong)
    assert store.task_groups() == []


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_are_refused(store: Store, name: str) -> None:
    calls: list[Callable[[], object]] = [lambda: store.remove_tasks(name)]
    for key in ((name, "house", "t"), ("ann", name, "t"), ("ann", "house", name)):
        calls += [
            lambda key=key: store.task(*key),  # type: ignore[misc]
            lambda key=key: store.remove_task(*key),  # type: ignore[misc]
            lambda key=key: store.put_task(record(key[2], key[0], key[1])),  # type: ignore[misc]
        ]
    for call in calls:
        with pytest.raises(InvalidInput):
            call()
