"""All stores, each of which keeps the contracts of stores, and two clients of rosbridge at a place without sockets."""

from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import cast

import pytest

from storage.ports import MapStore, Store
from storage.urls.opening import open_map_store, open_store
from tests.support.endpoints.still_place import StillClient, StillPlace


@pytest.fixture(params=["memory:", "sqlite://{folder}/store.db", pytest.param("cassandra", marks=pytest.mark.servers)])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Store]:
    if request.param == "cassandra":
        yield request.getfixturevalue("cassandra_store")
        return
    opened = open_store(request.param.format(folder=tmp_path))
    yield opened
    opened.close()


@pytest.fixture(params=["memory:", "file://{folder}/maps", pytest.param("hdfs", marks=pytest.mark.servers)])
def map_store(request: pytest.FixtureRequest, tmp_path: Path) -> MapStore:
    if request.param == "hdfs":
        return cast(MapStore, request.getfixturevalue("hdfs_store"))
    return open_map_store(request.param.format(folder=tmp_path))


@pytest.fixture
async def place() -> StillPlace:
    return StillPlace()


@pytest.fixture
async def client(place: StillPlace) -> AsyncIterator[StillClient]:
    made = StillClient(place)
    yield made
    made.session.end()


@pytest.fixture
async def other(place: StillPlace) -> AsyncIterator[StillClient]:
    made = StillClient(place, "operator")
    yield made
    made.session.end()
