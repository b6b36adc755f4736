"""Backends of stores, by URL scheme."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from storage.ports import MapStore, Store
from storage.urls.opening import open_map_store, open_store
from storage.urls.registry import MAP_STORES, STORES


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
