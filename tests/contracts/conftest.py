"""Every store that there is; what holds for one must hold for all."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from storage.ports import MapStore, Store
from storage.urls import open_map_store, open_store


@pytest.fixture(params=["memory:", "sqlite://{folder}/store.db"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Store]:
    opened = open_store(request.param.format(folder=tmp_path))
    yield opened
    opened.close()


@pytest.fixture(params=["memory:", "file://{folder}/maps"])
def map_store(request: pytest.FixtureRequest, tmp_path: Path) -> MapStore:
    return open_map_store(request.param.format(folder=tmp_path))
