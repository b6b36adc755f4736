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
from storage.ports import MapStore, Store
from storage.sqlite.store import SqliteStore
from storage.urls.opening import open_map_store, open_store
from storage.urls.registry import MAP_STORES, STORES
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


# Backends of stores, by URL scheme.


@pytest.mark.parametrize(
    "url", ["sqlite:", "sqlite:///", "sqlite://store.db", "sqlite://[x", "sqlite:///a?b", "sqlite:///a#b"]
)
def test_a_url_without_a_path_is_refused(url: str) -> None:
    with pytest.raises(InvalidInput):
        open_store(url)


def test_the_granularity_of_plans_is_set_in_the_url(tmp_path: Path) -> None:
    store = open_store(f"sqlite://{tmp_path}/store.db?granularity=64")
    assert store._granularity == 32  # type: ignore[attr-defined]
    store.close()
    for wrong in ("granularity=1", "granularity=-8", "granularity=", "size=3", "granularity=8&x=1"):
        with pytest.raises(InvalidInput, match="granularity"):
            open_store(f"sqlite://{tmp_path}/other.db?{wrong}")


def test_each_local_backend_opens_a_store_of_its_port(tmp_path: Path) -> None:
    for port, stores in (
        (Store, [open_store("memory:"), open_store(f"sqlite://{tmp_path}/store.db")]),
        (MapStore, [open_map_store("memory:"), open_map_store(f"file://{tmp_path}/maps")]),
    ):
        required = {name for name in dir(port) if not name.startswith("_")}
        for store in stores:
            assert required <= set(dir(store)), type(store)


def test_only_stores_of_servers_are_remote_and_need_an_extra() -> None:
    for backends, servers in ((STORES, {"cassandra"}), (MAP_STORES, {"hdfs"})):
        assert {name for name in backends.names() if backends.load(name).remote} == servers
        assert {name for name in backends.names() if backends.load(name).extra} == servers
