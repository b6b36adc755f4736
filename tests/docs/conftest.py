"""One real cloud for all documents."""

from collections.abc import Iterator

import pytest

from tests.support.cloud.cloud import RunningCloud, running_cloud


@pytest.fixture(scope="session")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a running cloud, stopped cleanly at the end; clones do not outlive a test."""
    with running_cloud(tmp_path_factory.mktemp("cloud"), "--linger", "0.2", "--device-host", "127.0.0.1") as running:
        yield running


@pytest.fixture
def own_cloud(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a cloud of one test, for pages whose commands change the map that other pages use."""
    with running_cloud(tmp_path_factory.mktemp("cloud"), "--linger", "0.2") as running:
        yield running
