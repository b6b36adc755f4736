"""Backends of stores, by URL scheme."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from storage.ports import MapStore, Store
from storage.urls.backends import MAP_STORES, STORES, Backend
from storage.urls.opening import open_store


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


@pytest.mark.parametrize(("backends", "port"), [(STORES, Store), (MAP_STORES, MapStore)])
def test_each_backend_implements_its_port(backends: dict[str, Backend[object]], port: type) -> None:
    required = {name for name in dir(port) if not name.startswith("_")}
    for scheme, backend in backends.items():
        assert required <= set(dir(backend.load())), scheme
