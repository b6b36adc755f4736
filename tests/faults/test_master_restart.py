"""SIGKILL of the web process and a restart on the same data: running containers are adopted, and nothing runs twice."""

import asyncio
import os
import signal
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from benchmarks.chaos.message_checks import MessageChecks
from benchmarks.harness.free_ports import free_ports
from engine.agent import main as agent_main
from engine.container.monitor.parameters import NAME as MONITOR
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback, MoveBaseActionResult
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud, shared_memory
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.joined_machine import JoinedMachine, container_of, machines, ticket
from tests.support.cloud.local_nodes import ABLE, managing, take_over
from tests.support.engine.docker_engine import image_for_tests
from tests.support.engine.processes import has_ended
from tests.support.network.wire import Wire, wire_to
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

THERE = "m2"

ADOPTED = ("--adopt-within", "120")
"""Option of clouds that are restarted; on a busy computer that takes longer than the default of 30 s."""


@asynccontextmanager
async def waiting_robot(
    cloud: RunningCloud,
    rest: RestClient,
    grid: GridMap,
    robot: str,
    parameters: dict[str, dict[str, Any]] | None = None,
) -> AsyncIterator[tuple[Drive, Wire, Pose2D]]:
    """Connect a robot over a wire that can be cut; yield its drive, the wire and a goal."""
    start = free_pose(grid, seed=32)
    goal = reachable_pose(grid, start, seed=42, at_least=1.5, at_most=3.0)
    await publish_map(rest, "office", grid)
    token = await register_robot(rest, robot, "office", start, parameters)
    async with wire_to(cloud.url) as wire, driving(wire.url, token, robot, grid, start) as drive:
        yield drive, wire, goal


async def start_driving(drive: Drive, goal: Pose2D) -> None:
    """Send the goal, and wait until the robot drives."""
    await drive.send(goal, goal_id="far")
    await until(lambda: drive.scorer.distance(0) > 0.3)


@asynccontextmanager
async def driving_robot(
    cloud: RunningCloud, rest: RestClient, grid: GridMap, robot: str
) -> AsyncIterator[tuple[Drive, Wire]]:
    """Drive a robot to a goal over a wire that can be cut; yield while it drives."""
    async with waiting_robot(cloud, rest, grid, robot) as (drive, wire, goal):
        await start_driving(drive, goal)
        yield drive, wire


def kill(cloud: RunningCloud, wire: Wire, folder: Path) -> None:
    """Kill the web process, and cut the wire of its robots."""
    os.kill(cloud.pid, signal.SIGKILL)
    cloud.status = -signal.SIGKILL
    wire.cut()
    (folder / "ready.json").unlink()


async def assert_continues(drive: Drive, wire: Wire, second: RunningCloud, before: dict[str, Any]) -> None:
    """Assert that a robot finds its earlier clone, which drives it to its goal once."""
    wrong: list[str] = []
    witness = MessageChecks("survivor", wrong.append)
    wire.mend(second.url)
    rest = await second.admin()
    await until(lambda: drive.robot.connections > 1)
    await drive.robot.subscribe(
        "move_base/feedback", MoveBaseActionFeedback, lambda message: witness.cycled(message.header.stamp.seconds())
    )
    after = await container_of(rest, "survivor")
    assert (after["id"], after["pid"], after["machine"]) == (before["id"], before["pid"], before["machine"])
    assert sum(machine["containers"] for machine in await rest.items("/v1/machines")) == 1
    result = await drive.result()
    assert (result.status.goal_id.id, result.status.status) == ("far", Status.SUCCEEDED), result.status.text
    assert drive.results.empty(), "one result a goal"
    assert wrong == []
    assert drive.robot.resumptions == drive.robot.connections - 1, "its session outlived the cloud process"
    assert (await container_of(rest, "survivor"))["pid"] == before["pid"]


@pytest.mark.parametrize(
    "image", [None, pytest.param(image_for_tests, marks=(pytest.mark.docker, pytest.mark.timeout(1800)))],
    ids=["process", "docker"],
)  # fmt: skip
async def test_the_clouds_own_machine_is_adopted(
    image: Callable[[], str] | None, tmp_path: Path, office_map: GridMap
) -> None:
    arguments = (*ADOPTED, *(("--runtime", "docker", "--image", image()) if image is not None else ()))
    with running_cloud(tmp_path, *arguments) as cloud:
        rest = await cloud.admin()
        async with driving_robot(cloud, rest, office_map, "survivor") as (drive, wire):
            before, agent = await container_of(rest, "survivor"), cloud.agent()
            kill(cloud, wire, tmp_path)
            with running_cloud(tmp_path, *arguments) as second:
                await assert_continues(drive, wire, second, before)
                assert agent.is_running() and not second.find(agent_main.__name__)
            assert has_ended(agent.pid) and has_ended(before["pid"]), "a clean stop ends adopted processes"
    assert not shared_memory(agent.pid)


async def test_a_robot_with_local_nodes_drives_on_and_finds_the_new_cloud(tmp_path: Path, office_map: GridMap) -> None:
    own = {"amcl", "move_base"}
    patient = {MONITOR: {"patience": 60.0}}  # a busy computer takes longer to start a cloud than the default of 3 s
    with running_cloud(tmp_path, *ADOPTED) as cloud:
        rest = await cloud.admin()
        async with (
            waiting_robot(cloud, rest, office_map, "survivor", patient) as (drive, wire, goal),
            managing(drive.robot, ABLE) as manager,
        ):
            await take_over(manager, *own)
            await start_driving(drive, goal)
            before = await container_of(rest, "survivor")
            kill(cloud, wire, tmp_path)
            driven = drive.scorer.distance(0)
            await until(lambda: drive.scorer.distance(0) > driven + 0.3)
            with running_cloud(tmp_path, *ADOPTED) as second:
                await assert_continues(drive, wire, second, before)
                # After a break longer than its patience the cloud would have taken the nodes over.
                await until(lambda: manager.running == own)


async def test_a_machine_of_another_host_is_adopted_and_its_endpoint_keeps_its_sockets(
    tmp_path: Path, office_map: GridMap
) -> None:
    machines_port, _, port = free_ports(3)
    listen = (*ADOPTED, "--listen-machines", f"127.0.0.1:{machines_port}", "--cores", "1")
    joined = JoinedMachine(tmp_path / "m2", THERE)
    with running_cloud(tmp_path, *listen) as cloud:
        joined.start(ticket(tmp_path / "data"), "--endpoints", "1", "--port", str(port))
        rest = await cloud.admin()
        await joined.is_in(rest)
        await rest.patch("/v1/machines/local", {"max_containers": 0})
        async with (
            driving_robot(cloud, rest, office_map, "survivor") as (drive, wire),
            operator_at(f"http://127.0.0.1:{port}", rest, "survivor") as (operator, results),
        ):
            before = await container_of(rest, "survivor")
            assert before["machine"] == THERE
            await rest.patch("/v1/machines/local", {"max_containers": 100})
            kill(cloud, wire, tmp_path)
            with running_cloud(tmp_path, *listen) as second:
                await assert_continues(drive, wire, second, before)
                assert await machines(await second.admin()) == ["local", THERE]
                await until(lambda: len(results) == 1)
                assert (operator.connections, results[0].status.status) == (1, Status.SUCCEEDED)
                joined.end()


@asynccontextmanager
async def operator_at(
    url: str, rest: RestClient, robot: str
) -> AsyncIterator[tuple[RobotClient, list[MoveBaseActionResult]]]:
    """Connect an operator of a robot at an endpoint, once that serves; yield it with the results that it hears."""
    async with patience(60.0):
        while len(await rest.items("/v1/endpoints")) < 2:
            await asyncio.sleep(0.05)
    assert rest.token is not None
    results: list[MoveBaseActionResult] = []
    async with RobotClient(url, robot=robot, token=rest.token, role="operator") as operator:
        await operator.subscribe("move_base/result", MoveBaseActionResult, results.append)
        yield operator, results


async def test_a_cloud_that_never_returns_leaves_nothing(tmp_path: Path, office_map: GridMap) -> None:
    with running_cloud(tmp_path, "--adopt-within", "3") as cloud:
        rest = await cloud.admin()
        async with driving_robot(cloud, rest, office_map, "survivor") as (_, wire):
            before, family, agent = await container_of(rest, "survivor"), cloud.children(), cloud.agent()
            kill(cloud, wire, tmp_path)
            await asyncio.sleep(0.5)
            assert not has_ended(before["pid"]), "the machine waits for another master"
            await until(lambda: all(has_ended(process.pid) for process in family))
            assert not shared_memory(agent.pid)
