"""One real cloud for all journeys that do not break it."""

import asyncio
import shutil
import socket
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser

from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from tests.support.cloud.browser import browsing
from tests.support.cloud.cloud import RunningCloud, running_cloud

ROSLIB = Path(__file__).parent / "roslib"


@pytest.fixture
def node() -> str:
    """Return the command of Node; ``make test`` installs roslib if Node is installed."""
    found = shutil.which("node")
    if found is None or not (ROSLIB / "node_modules" / "roslib").is_dir():
        pytest.skip("Node, or roslib in it, is not installed: install Node 20 or newer and run make test")
    return found


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser() -> AsyncIterator[Browser]:
    """Return a browser for the tests of a module, each of which opens a context without data of the others."""
    async with browsing() as started:
        yield started


@pytest.fixture(scope="session")
def rapyuta_port() -> int:
    """Return the port of the cloud for robots of Rapyuta."""
    return _free_port()


@pytest.fixture(scope="session")
def foxglove_port() -> int:
    """Return the port of the cloud for viewers of Foxglove."""
    return _free_port()


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
    return port


@pytest.fixture(scope="session")
def cloud(tmp_path_factory: pytest.TempPathFactory, rapyuta_port: int, foxglove_port: int) -> Iterator[RunningCloud]:
    """Return a running cloud, stopped cleanly at the end."""
    folder: Path = tmp_path_factory.mktemp("cloud")
    ports = ("--rapyuta", str(rapyuta_port), "--foxglove", str(foxglove_port))
    with running_cloud(folder, *ports, "--device-host", "127.0.0.1") as running:
        asyncio.run(_raise_oversubscription(running))
        yield running


async def _raise_oversubscription(cloud: RunningCloud) -> None:
    """Allow more containers: each journey leaves some that linger, clones or planning on its map."""
    admin = await cloud.admin()
    await admin.patch("/v1/machines/local", {"oversubscription": 32})


@pytest.fixture(scope="session")
def office_map() -> GridMap:
    """Return a generated office, 12 × 10 m."""
    return office(seed=1, width=12.0, height=10.0)
