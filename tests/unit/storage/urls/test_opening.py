"""Opening stores by URL."""

import subprocess
import sys
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from storage.files.store import FileMapStore
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.sqlite.store import SqliteStore
from storage.urls.opening import open_map_store, open_store
from tests.support.storage.records import house, put_map, user


def test_the_scheme_chooses_the_store(tmp_path: Path) -> None:
    assert type(open_store("memory:")) is MemoryStore
    assert type(open_store(f"sqlite://{tmp_path}/store.db")) is SqliteStore
    assert type(open_map_store("memory:")) is MemoryMapStore
    assert type(open_map_store(f"file://{tmp_path}/maps")) is FileMapStore


def test_the_path_is_where_the_store_is(tmp_path: Path) -> None:
    open_store(f"sqlite://{tmp_path}/a%20b/store.db").add_user(user("ann"))
    assert (tmp_path / "a b" / "store.db").is_file()
    put_map(open_map_store(f"file://{tmp_path}/maps"), house())
    assert (tmp_path / "maps" / "house" / "log" / "00000001").is_file()


def test_a_path_without_slashes_is_relative(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    open_store("sqlite:var/store.db").close()
    open_map_store("file:var/maps")
    assert (tmp_path / "var" / "store.db").is_file()
    assert (tmp_path / "var" / "maps").is_dir()


@pytest.mark.parametrize("url", ["", "mysql://db", "/var/store.db", "file:///maps", "SQLITE", "memory"])
def test_an_unknown_kind_is_refused_and_the_known_are_named(url: str) -> None:
    with pytest.raises(InvalidInput, match="known: memory:, sqlite:, cassandra:"):
        open_store(url)


def test_the_known_kinds_of_map_stores_are_their_own() -> None:
    with pytest.raises(InvalidInput, match="known: memory:, file:, hdfs:"):
        open_map_store("sqlite:///maps.db")


def test_a_store_for_a_fleet_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    for driver in ("cassandra", "hdfs"):
        for module in [name for name in sys.modules if name.startswith((driver, f"storage.{driver}"))]:
            monkeypatch.delitem(sys.modules, module)
        monkeypatch.setitem(sys.modules, driver, None)  # as if it were not installed
    with pytest.raises(InvalidInput, match=r"\.\[cassandra\]"):
        open_store("cassandra://db/ppaas")
    with pytest.raises(InvalidInput, match=r"\.\[hdfs\]"):
        open_map_store("hdfs://namenode/maps")


def test_what_is_not_asked_for_is_not_imported() -> None:
    others = "{'sqlite3', 'cassandra', 'hdfs'}"
    code = f"import sys, storage.urls.opening as u; u.open_store('memory:'); assert not {others} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_store_on_this_machine_needs_no_outbox(tmp_path: Path) -> None:
    assert type(open_store("memory:", outbox=tmp_path / "outbox.sqlite")) is MemoryStore
    assert not list(tmp_path.iterdir())
