"""All stores, and two rosbridge clients at a place without sockets."""

from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest

from storage.ports import MapStore, Store
from storage.urls.opening import open_map_store, open_store
from tests.servers.fixtures import empty_hdfs_store
from tests.servers.jars import OTHER_HADOOPS
from tests.support.endpoints.still_place_fixtures import client, other, place

__all__ = ["client", "map_store", "other", "place", "store"]


@pytest.fixture(params=["memory:", "sqlite://{folder}/store.db", pytest.param("cassandra", marks=pytest.mark.servers)])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Store]:
    if request.param == "cassandra":
        yield request.getfixturevalue("cassandra_store")
        return
    opened = open_store(request.param.format(folder=tmp_path))
    yield opened
    opened.close()


IN_HDFS = {"hdfs": None, **{f"hdfs {version}": version for version in OTHER_HADOOPS}}


@pytest.fixture(
    params=["memory:", "file://{folder}/maps", *(pytest.param(name, marks=pytest.mark.servers) for name in IN_HDFS)]
)
def map_store(request: pytest.FixtureRequest, tmp_path: Path) -> MapStore:
    if request.param in IN_HDFS:
        return cast(MapStore, empty_hdfs_store(request.getfixturevalue("hdfs_servers")(IN_HDFS[request.param])))
    return open_map_store(request.param.format(folder=tmp_path))
