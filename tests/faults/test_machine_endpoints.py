"""Endpoints of a joined machine serve robots whose containers are anywhere, and are killed under them."""

import asyncio
import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from benchmarks.harness.free_ports import free_ports
from endpoints.cloud_processes import serving
from ppaas.errors import Unavailable
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, named, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.joined_machine import JoinedMachine, container_of, ticket
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

HERE, THERE = "local", "hall"


class Hall:
    """A joined machine with one endpoint."""

    def __init__(self, folder: Path, cloud: RunningCloud) -> None:
        [port] = free_ports(1)
        self.url = f"http://127.0.0.1:{port}"
        self.machine = JoinedMachine(folder / THERE, THERE)
        self.machine.start(
            ticket(folder / "data"), "--endpoints", "1", "--port", str(port), "--advertise", self.url
        )  # fmt: skip
        self.cloud = cloud

    def endpoint(self) -> psutil.Process:
        """Return the process of its endpoint."""
        [found] = named(psutil.Process(self.machine.process.pid).children(), serving.__name__)
        return found


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    folder = tmp_path_factory.mktemp("hall")
    with running_cloud(folder, "--listen-machines", "127.0.0.1:0") as cloud:
        made = Hall(folder, cloud)
        yield made
        made.machine.end()


async def admin(hall: Hall, place: str) -> RestClient:
    """Return an administrator of the cloud, which places containers on one machine only."""
    rest = await hall.cloud.admin()
    await hall.machine.is_in(rest)
    await until_served(rest, 2)
    for machine in (HERE, THERE):
        await rest.patch(f"/v1/machines/{machine}", {"draining": machine != place})
    return rest


async def until_served(rest: RestClient, endpoints: int) -> None:
    """Wait until the cloud has this many endpoints that report."""
    async with patience(60.0):
        while [one["state"] for one in await rest.items("/v1/endpoints")] != ["ready"] * endpoints:
            await asyncio.sleep(0.05)


async def sockets(rest: RestClient) -> dict[str, int]:
    """Return the number of sockets of each endpoint."""
    return {one["id"]: one["sockets"] for one in await rest.items("/v1/endpoints")}


async def until_at(rest: RestClient, endpoint: str) -> None:
    """Wait until all sockets, of a robot and its operator, are at one endpoint; the one asked may be down meanwhile."""
    found: set[str] = set()
    async with patience(30.0):
        while found != {endpoint}:
            await asyncio.sleep(0.2)
            with suppress(Unavailable):
                found = {name for name, count in (await sockets(rest)).items() if count}


async def arrives(drive: Drive, goal_id: str) -> None:
    """Wait for the one result of a goal."""
    result = await drive.result()
    assert (result.status.goal_id.id, result.status.status) == (goal_id, Status.SUCCEEDED), result.status.text
    await asyncio.sleep(0.5)
    assert drive.results.empty(), "one result a goal"


@pytest.mark.parametrize("place", [HERE, THERE])
async def test_an_endpoint_of_another_machine_serves_and_is_killed(hall: Hall, office_map: GridMap, place: str) -> None:
    """The container is on the cloud's machine, and then on the endpoint's own; REST is served there, too."""
    rest, name = await admin(hall, place), f"tb-{place}"
    start = free_pose(office_map, seed=32)
    goal = reachable_pose(office_map, start, seed=42, at_least=1.5, at_most=3.0)
    far = RestClient(hall.url, rest.token)
    await publish_map(far, name, office_map)
    token = await register_robot(far, name, name, start)
    async with driving(hall.url, token, name, office_map, start) as drive:
        assert (await container_of(far, name))["machine"] == place
        await until_at(rest, "hall-1")
        await drive.send(goal, goal_id="far")
        await until(lambda: drive.scorer.distance(0) > 0.3, 30.0)
        killed = hall.endpoint()
        os.kill(killed.pid, signal.SIGKILL)
        await arrives(drive, "far")
        for client in (drive.robot, drive.operator):
            assert client.connections >= 2, "both were cut off"
            assert client.resumptions == client.connections - 1, "its session outlived the endpoint"
    actions = [event["action"] for event in (await rest.get("/v1/audit?limit=100"))["items"]]
    assert "connect" in actions and "put_robot" in actions, "what happened there is in the log of the cloud"


async def test_a_robot_goes_to_the_endpoint_beside_its_container(hall: Hall, office_map: GridMap) -> None:
    """It comes by the cloud's endpoint, which is killed; its next connection is to the one on its machine."""
    rest = await admin(hall, THERE)
    start = free_pose(office_map, seed=34)
    goal = reachable_pose(office_map, start, seed=44, at_least=1.5, at_most=3.0)
    await publish_map(rest, "nearer", office_map)
    token = await register_robot(rest, "nearer", "nearer", start)
    async with driving(hall.cloud.url, token, "nearer", office_map, start) as drive:
        assert (await container_of(rest, "nearer"))["machine"] == THERE
        await until_at(rest, "local-1")
        await drive.send(goal, goal_id="near")
        await until(lambda: drive.scorer.distance(0) > 0.3, 30.0)
        [own] = hall.cloud.find(serving.__name__)
        os.kill(own.pid, signal.SIGKILL)
        await arrives(drive, "near")
        rest = await hall.cloud.admin()
        await until_at(rest, "hall-1")
        for client in (drive.robot, drive.operator):
            assert client.resumptions == client.connections - 1 >= 1
