"""A record that another release wrote in a form that this one cannot read is named so, and spoils no other."""

from collections.abc import Callable
from typing import Any, cast

import msgspec
import pytest

from ppaas import __version__
from ppaas.errors import Unavailable
from ppaas.tasks.records import Task
from storage import encoding
from storage.files import log_entries
from storage.ports import MapStore, Store
from storage.records import MapTask
from tests.support.storage.records import clone, house, put_map, robot, user

LATER = "9.1.0"
OTHER = rf"is a record of another release of PPaaS \({LATER}\), which this one \({__version__}\) cannot read \("
TASK = Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),))

# Stores in memory keep the records themselves, which no other release writes.
STORES = ["sqlite://{folder}/store.db", pytest.param("cassandra", marks=pytest.mark.servers)]
MAP_STORES = ["file://{folder}/maps", pytest.param("hdfs", marks=pytest.mark.servers)]


@pytest.fixture
def of_later_release(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let records say that a later release writes them."""
    monkeypatch.setattr(encoding, "_WRITTEN_BY", msgspec.msgpack.encode("release") + msgspec.msgpack.encode(LATER))
    monkeypatch.setattr(log_entries, "_WRITTEN_BY", b'"release":' + msgspec.json.encode(LATER) + b",")


def unknown(record: Any, **fields: object) -> Any:
    """Return a record with values that this release does not know."""
    return msgspec.structs.replace(record, **fields)


RECORDS: dict[str, tuple[Callable[[Store], None], Callable[[Store], object]]] = {
    "users/ann": (lambda s: s.add_user(unknown(user("ann"), role="janitor")), lambda s: s.user("ann")),
    "robots/bob/tb1": (
        lambda s: s.put_robot(unknown(robot("tb1", user="bob"), cores="many")),
        lambda s: s.robot("bob", "tb1"),
    ),
    "clones/bob/tb1": (
        lambda s: s.save_clone(unknown(clone("tb1", user="bob"), saved="yesterday")),
        lambda s: s.clone("bob", "tb1"),
    ),
    "tasks/bob/house/t1": (
        lambda s: s.put_task(MapTask("bob", "house", unknown(TASK, reason=5))),
        lambda s: s.task("bob", "house", "t1"),
    ),
}


@pytest.mark.parametrize("store", STORES, indirect=True)
@pytest.mark.parametrize("place", RECORDS)
def test_a_record_of_another_release_is_named_with_both(store: Store, of_later_release: None, place: str) -> None:
    store.add_user(user("bob"))
    store.put_robot(robot("tb2", user="bob"))
    write, read = RECORDS[place]
    write(store)
    with pytest.raises(Unavailable, match=f"{place} {OTHER}"):
        read(store)
    assert [one.id for one in store.users() if one.id != "ann"] == ["bob"]
    assert [one.id for one in store.robots("bob") if one.id != "tb1"] == ["tb2"]


@pytest.mark.parametrize("map_store", MAP_STORES, indirect=True)
def test_a_map_of_another_release_is_named_with_both(
    map_store: MapStore, of_later_release: None, caplog: pytest.LogCaptureFixture
) -> None:
    put_map(map_store, house(map_id="shed"))
    put_map(map_store, house(description=cast(str, 5)))
    with pytest.raises(Unavailable, match=f"house/log/.* of the maps {OTHER}"):
        map_store.map_head("house")
    assert [head.id for head in map_store.maps()] == ["shed"]
    assert "of another release" in caplog.text


def test_records_of_a_later_release_that_can_be_read_are_read(store: Store, of_later_release: None) -> None:
    store.add_user(user("ann"))
    assert store.user("ann") == user("ann")
