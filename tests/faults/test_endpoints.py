"""SIGKILL and SIGSTOP of endpoints under a driving robot, which finds its session and its goal at another one."""

import asyncio
import os
import signal
from collections.abc import Iterator

import psutil
import pytest

from endpoints.cloud_processes import serving
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.joined_machine import container_of
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    with running_cloud(tmp_path_factory.mktemp("endpoints"), "--endpoints", "2") as made:
        yield made


def endpoints(cloud: RunningCloud) -> list[psutil.Process]:
    """Return the endpoint processes."""
    return cloud.find(serving.__name__)


def served_by(cloud: RunningCloud) -> psutil.Process:
    """Return the endpoint that has the most connections of clients."""
    port = int(cloud.url.rpartition(":")[2])

    def sockets(process: psutil.Process) -> int:
        return sum(c.status == "ESTABLISHED" and c.laddr.port == port for c in process.net_connections("tcp"))

    return max(endpoints(cloud), key=sockets)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
async def test_a_robot_drives_on_by_another_endpoint(
    cloud: RunningCloud, office_map: GridMap, number: signal.Signals
) -> None:
    rest = await cloud.admin()
    name, map_id = f"tb-{number.name.lower()}", f"office-{number.name.lower()}"
    start = free_pose(office_map, seed=32)
    goal = reachable_pose(office_map, start, seed=42, at_least=1.5, at_most=3.0)
    await publish_map(rest, map_id, office_map)
    token = await register_robot(rest, name, map_id, start)
    async with driving(cloud.url, token, name, office_map, start) as drive:
        await drive.send(goal, goal_id="far")
        await until(lambda: drive.scorer.distance(0) > 0.3, 30.0)
        before = await container_of(rest, name)
        lost = served_by(cloud).pid
        os.kill(lost, number)
        await _assert_ends_once(drive, goal)
        assert (await container_of(rest, name))["pid"] == before["pid"]
    await until(lambda: _is_replaced(cloud, lost))


def _is_replaced(cloud: RunningCloud, lost: int) -> bool:
    """Return whether another process runs instead of an endpoint; a stopped one stays until the master kills it."""
    pids = [process.pid for process in endpoints(cloud)]
    return len(pids) == 2 and lost not in pids


async def _assert_ends_once(drive: Drive, goal: Pose2D) -> None:
    result = await drive.result()
    assert (result.status.goal_id.id, result.status.status) == ("far", Status.SUCCEEDED), result.status.text
    assert drive.scorer.error(0, goal) < 0.5
    await asyncio.sleep(1.0)
    assert drive.results.empty(), "one result a goal"
    for client in (drive.robot, drive.operator):
        assert client.resumptions == client.connections - 1, "its session outlived the endpoint"


async def test_a_robot_connects_once_over_all_endpoints(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    start = free_pose(office_map, seed=33)
    await publish_map(rest, "twice", office_map)
    token = await register_robot(rest, "twice", "twice", start)
    async with driving(cloud.url, token, "twice", office_map, start):
        refused = 0
        for _ in range(8):  # the system gives each connection to one of the endpoints
            refused += await _is_refused(cloud, token, "twice")
        assert refused == 8


async def _is_refused(cloud: RunningCloud, token: str, robot: str) -> bool:
    from websockets.asyncio.client import connect
    from websockets.exceptions import InvalidStatus

    try:
        async with connect(f"{cloud.ws_url}/?robot={robot}&token={token}"):
            return False
    except InvalidStatus as refused:
        return refused.response.status_code == 409
