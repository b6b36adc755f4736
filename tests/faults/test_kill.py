"""SIGKILL of each process of a machine, one by one, while robots drive: they are served again."""

import asyncio
import itertools
import os
import signal
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from tests.support.cloud.cloud import (
    RunningCloud,
    publish_map,
    register_robot,
    running_cloud,
    shared_memory,
)
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ROBOTS = 3
SERVED_AGAIN = 30.0
"""Time limit [s]; `ppaas bench engine` measures the time on an otherwise idle host."""

VICTIMS: dict[str, Callable[[RunningCloud], psutil.Process]] = {
    "container": RunningCloud.container,
    "router": RunningCloud.router,
    "fork server": RunningCloud.fork_server,
    "agent": RunningCloud.agent,
}


@pytest.mark.parametrize("victim", VICTIMS)
async def test_robots_are_served_again_after_kill_9(
    victim: str, cloud: RunningCloud, office_map: GridMap, record_property: Callable[[str, object], None]
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    gap = await gap_of_kill(VICTIMS[victim], cloud, rest, office_map, range(ROBOTS))
    record_property("longest_gap_s", gap)
    assert gap <= SERVED_AGAIN


async def gap_of_kill(
    find: Callable[[RunningCloud], psutil.Process],
    cloud: RunningCloud,
    rest: RestClient,
    grid: GridMap,
    robots: range,
) -> float:
    """Kill a process while robots drive; return the longest time without a command of any of them [s]."""
    async with asyncio.TaskGroup() as group:
        all_drive = asyncio.Barrier(len(robots) + 1)
        driven = [group.create_task(drive_through(cloud, rest, grid, n, all_drive)) for n in robots]
        group.create_task(kill_when(all_drive, find, cloud))
    return max(task.result() for task in driven)


async def drive_through(
    cloud: RunningCloud, rest: RestClient, grid: GridMap, number: int, all_drive: asyncio.Barrier
) -> float:
    """Drive through the fault; return the longest time without a command before the goal was reached [s]."""
    start = free_pose(grid, seed=30 + number)
    goal = reachable_pose(grid, start, seed=40 + number, at_least=2.5, at_most=4.0)
    token = await register_robot(rest, f"f{number}", "office", start)
    async with driving(cloud.url, token, f"f{number}", grid, start) as drive:
        await drive.send(goal, goal_id=f"goal-{number}")
        await until(lambda: len(drive.commands) > 5)
        await all_drive.wait()
        result = await drive.result()
        assert result.status.goal_id.id == f"goal-{number}", "only the goal that was sent ended"
        assert result.status.status == Status.SUCCEEDED, result.status.text
        assert drive.scorer.error(0, goal) <= 0.25
        assert drive.results.empty(), "one result a goal"
        assert drive.robot.connections == 1, "the robot's socket was kept open"
        return longest_gap(drive)


def longest_gap(drive: Drive) -> float:
    times = [time for time, _ in drive.commands]
    return max(after - before for before, after in itertools.pairwise(times))


async def kill_when(
    all_drive: asyncio.Barrier, find: Callable[[RunningCloud], psutil.Process], cloud: RunningCloud
) -> None:
    await all_drive.wait()
    process = find(cloud)
    below = process.children(recursive=True)
    os.kill(process.pid, signal.SIGKILL)
    await until(lambda: not any(is_orphan(p) for p in below))
    await until(lambda: not lives(process))


async def test_killing_the_web_process_ends_all_processes_without_adoption(tmp_path: Path, office_map: GridMap) -> None:
    with running_cloud(tmp_path, "--adopt-within", "0") as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        start = free_pose(office_map, seed=30)
        token = await register_robot(rest, "r", "office", start)
        async with driving(cloud.url, token, "r", office_map, start):
            below, sockets, agent = cloud.children(), run_dir(cloud), cloud.agent()
            assert sockets.is_dir() and shared_memory(agent.pid)
            os.kill(cloud.pid, signal.SIGKILL)
            cloud.status = -signal.SIGKILL
        await until(lambda: not any(lives(process) for process in below))
        assert not sockets.exists()
        assert not shared_memory(agent.pid)


def run_dir(cloud: RunningCloud) -> Path:
    """Return the folder of the sockets that a cloud listens on."""
    addresses = {str(c.laddr) for c in psutil.Process(cloud.pid).net_connections("unix")}
    (link,) = {Path(address) for address in addresses if address.endswith("/link.sock")}
    return link.parent


def is_orphan(process: psutil.Process) -> bool:
    """Return whether a process runs although its parent has exited."""
    try:
        return lives(process) and process.ppid() == 1
    except psutil.NoSuchProcess:
        return False


def lives(process: psutil.Process) -> bool:
    """Return whether a process runs and is not a zombie."""
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
