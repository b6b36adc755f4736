"""A cloud of two machines, the second joined over TLS, with one driving robot on each."""

import asyncio
import itertools
import signal
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from urllib.parse import urlsplit

import msgspec
import psutil
import pytest

from engine.remote.joining import read_ticket
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.e2e.test_masks import careful_robot, passed
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.joined_machine import JoinedMachine, container_of, machines, ticket
from tests.support.engine.processes import has_ended
from tests.support.network.wire import wire_to
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

HERE, THERE = "local", "m2"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("two")


@pytest.fixture(scope="module")
def two_machines(folder: Path) -> Iterator[RunningCloud]:
    """Return a cloud that accepts machines of other hosts."""
    with running_cloud(folder, "--listen-machines", "127.0.0.1:0", "--linger", "1", "--adopt-within", "5") as running:
        yield running


@pytest.fixture(scope="module")
def second(two_machines: RunningCloud, folder: Path) -> Iterator[JoinedMachine]:
    """Return a machine that joined with a ticket; it leaves nothing behind at the end."""
    machine = JoinedMachine(folder / "m2", THERE)
    machine.start(ticket(folder / "data"))
    yield machine
    machine.end()


@asynccontextmanager
async def driving_on_both(
    cloud: RunningCloud, rest: RestClient, grid: GridMap, names: tuple[str, str]
) -> AsyncIterator[dict[str, Drive]]:
    """Drive two robots, each on its own map and machine; yield that of the second machine last."""
    async with patience(30.0):
        while await rest.items("/v1/containers"):
            await asyncio.sleep(0.05)
    await limit_each(rest, 1)  # so that each machine gets one
    start = free_pose(grid, seed=30)
    goal = reachable_pose(grid, start, seed=40, at_least=2.0, at_most=3.0)
    for name in names:
        await publish_map(rest, name, grid)
        token = await register_robot(rest, name, name, start)
    async with (
        driving(cloud.url, token, names[0], grid, start) as one,
        driving(cloud.url, token, names[1], grid, start) as other,
    ):
        served = {(await container_of(rest, name))["machine"]: name for name in names}
        assert set(served) == {HERE, THERE}, "each map has a machine of its own"
        await limit_each(rest, 100)
        drives = dict(zip(names, (one, other), strict=True))
        for name, drive in drives.items():
            await drive.send(goal, goal_id=name)
        await until(lambda: all(len(drive.commands) > 5 for drive in drives.values()), 30.0)
        yield {served[HERE]: drives[served[HERE]], served[THERE]: drives[served[THERE]]}


async def limit_each(rest: RestClient, containers: int) -> None:
    """Set the largest number of containers of each machine."""
    for machine in (HERE, THERE):
        await rest.patch(f"/v1/machines/{machine}", {"max_containers": containers})


async def all_arrive(drives: dict[str, Drive]) -> float:
    """Wait until each robot has arrived once, with its socket open; return the longest gap between commands [s]."""
    for name, drive in drives.items():
        result = await drive.result()
        assert (result.status.goal_id.id, result.status.status) == (name, Status.SUCCEEDED), result.status.text
        assert drive.results.empty(), "one result a goal"
        assert drive.robot.connections == 1, "the robot's socket was kept open"
    times = [[time for time, _ in drive.commands] for drive in drives.values()]
    return max(after - before for one in times for before, after in itertools.pairwise(one))


async def test_robots_of_a_killed_machine_continue_on_the_other(
    two_machines: RunningCloud,
    second: JoinedMachine,
    office_map: GridMap,
    record_property: Callable[[str, object], None],
) -> None:
    rest = await two_machines.admin()
    await second.is_in(rest)
    async with driving_on_both(two_machines, rest, office_map, ("k1", "k2")) as drives:
        second.signal(signal.SIGKILL)
        assert await second.has_ended() == -signal.SIGKILL
        record_property("longest_gap_s", await all_arrive(drives))
        for name in drives:
            assert (await container_of(rest, name))["machine"] == HERE
        assert await machines(rest) == [HERE]
    second.start()  # it has joined already
    await second.is_in(rest)


async def test_a_frozen_machine_is_replaced_and_rejoins(
    two_machines: RunningCloud,
    second: JoinedMachine,
    office_map: GridMap,
    record_property: Callable[[str, object], None],
) -> None:
    rest = await two_machines.admin()
    await second.is_in(rest)
    async with driving_on_both(two_machines, rest, office_map, ("f1", "f2")) as drives:
        left = (await container_of(rest, tuple(drives)[1]))["pid"]
        second.process.send_signal(signal.SIGSTOP)
        record_property("longest_gap_s", await all_arrive(drives))
        for name in drives:
            assert (await container_of(rest, name))["machine"] == HERE
        assert psutil.pid_exists(left), "a frozen machine cannot be ended"
        second.process.send_signal(signal.SIGCONT)
        async with patience(20.0):
            while not has_ended(left):
                await asyncio.sleep(0.02)
        await second.is_in(rest)
        for drive in drives.values():
            assert drive.results.empty(), "late results of the frozen machine are not delivered"


async def test_robots_of_a_drained_machine_continue_on_the_other(
    two_machines: RunningCloud,
    second: JoinedMachine,
    office_map: GridMap,
    record_property: Callable[[str, object], None],
) -> None:
    rest = await two_machines.admin()
    await second.is_in(rest)
    async with driving_on_both(two_machines, rest, office_map, ("d1", "d2")) as drives:
        drained = await rest.patch(f"/v1/machines/{THERE}", {"draining": True})
        assert drained["state"] == "draining"
        record_property("longest_gap_s", await all_arrive(drives))
        for name in drives:
            assert (await container_of(rest, name))["machine"] == HERE
        seen = await rest.get(f"/v1/machines/{THERE}")
        assert (seen["state"], seen["containers"]) == ("drained", 0)
        assert 0.0 < seen["round_trips"][HERE] < 1.0 and seen["round_trip"] > 0.0
    await rest.patch(f"/v1/machines/{THERE}", {"draining": False})


async def test_a_robot_on_another_machine_respects_its_keepout_mask(
    two_machines: RunningCloud, second: JoinedMachine
) -> None:
    rest = await two_machines.admin()
    await second.is_in(rest)
    token = await careful_robot(rest, "far")
    await rest.patch(f"/v1/machines/{HERE}", {"max_containers": 0})
    async with RobotClient(two_machines.ws_url, robot="far", token=token) as client:
        await limit_each(rest, 100)
        assert (await container_of(rest, "far"))["machine"] == THERE
        assert await passed(client) == {True}


async def test_a_disconnected_machine_ends_its_containers_and_rejoins(
    two_machines: RunningCloud, second: JoinedMachine, office_map: GridMap, folder: Path
) -> None:
    rest = await two_machines.admin()
    await second.is_in(rest)
    cut_off = JoinedMachine(folder / "m3", "m3")
    direct = read_ticket(ticket(folder / "data"))
    await publish_map(rest, "silent", office_map)
    start = free_pose(office_map, seed=30)
    token = await register_robot(rest, "s1", "silent", start)
    async with wire_to(f"http://{direct.address.authority}") as wire:
        port = urlsplit(wire.url).port
        assert port is not None
        cut_off.start(str(msgspec.structs.replace(direct, port=port)))
        await cut_off.is_in(rest)
        await limit_each(rest, 0)
        async with driving(two_machines.url, token, "s1", office_map, start) as drive:
            await limit_each(rest, 100)
            there = await container_of(rest, "s1")
            assert there["machine"] == "m3"
            wire.fall_silent()
            async with patience(20.0):
                while not any(c["machine"] in (HERE, THERE) for c in await rest.items("/v1/containers")):
                    await asyncio.sleep(0.05)
                while not has_ended(there["pid"]):
                    await asyncio.sleep(0.02)
            assert drive.robot.connections == 1
        await cut_off.is_in(rest)  # over a new connection
        cut_off.end()
