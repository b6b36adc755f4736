"""Opening stores by URL."""

import subprocess
import sys
from pathlib import Path

import pytest

from ppaas import distribution
from ppaas.errors import InvalidInput, Unavailable
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


def test_the_path_locates_the_store(tmp_path: Path) -> None:
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
def test_an_unknown_scheme_is_refused_with_the_known_ones(url: str) -> None:
    with pytest.raises(InvalidInput, match=r"known: cassandra:, memory:, sqlite:$"):
        open_store(url)


def test_map_stores_have_their_own_schemes() -> None:
    with pytest.raises(InvalidInput, match=r"known: file:, hdfs:, memory:$"):
        open_map_store("sqlite:///maps.db")


def test_a_missing_driver_is_reported_with_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for driver in ("cassandra", "hdfs"):
        for module in [name for name in sys.modules if name.startswith((driver, f"storage.{driver}"))]:
            monkeypatch.delitem(sys.modules, module)
        monkeypatch.setitem(sys.modules, driver, None)  # as if it were not installed
    with pytest.raises(InvalidInput, match=r"\.\[cassandra\]"):
        open_store("cassandra://db/ppaas")
    with pytest.raises(InvalidInput, match=r"\.\[hdfs\]"):
        open_map_store("hdfs://namenode/maps")


def test_unused_backends_are_not_imported() -> None:
    others = "{'sqlite3', 'cassandra', 'hdfs'}"
    code = f"import sys, storage.urls.opening as u; u.open_store('memory:'); assert not {others} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_local_store_needs_no_outbox(tmp_path: Path) -> None:
    assert type(open_store("memory:", outbox=tmp_path / "outbox.sqlite")) is MemoryStore
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("url", "driver"), [("cassandra://db/ppaas", "cassandra-driver"), ("hdfs://namenode/maps", "hdfs")]
)
def test_an_old_driver_is_named(url: str, driver: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distribution, "version", lambda name: "1.0" if name == driver else "99.0")
    with pytest.raises(Unavailable, match=rf"{driver} 1\.0 \(needed: >="):
        (open_map_store if driver == "hdfs" else open_store)(url)
