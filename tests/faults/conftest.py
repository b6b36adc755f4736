"""Each fault has its own cloud, which is stopped cleanly at the end and leaves nothing behind."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, running_cloud


@pytest.fixture
def cloud(tmp_path: Path) -> Iterator[RunningCloud]:
    """Return a running cloud."""
    with running_cloud(tmp_path) as running:
        yield running


@pytest.fixture(scope="session")
def office_map() -> GridMap:
    """Return a generated office, 12 × 10 m."""
    return office(seed=1, width=12.0, height=10.0)
