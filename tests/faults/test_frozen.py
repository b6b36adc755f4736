"""SIGSTOP of each process of a machine, one by one, while a robot drives: each is replaced."""

import os
import signal
from collections.abc import Callable

import psutil
import pytest

from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from tests.faults.test_kill import SERVED_AGAIN, lives, longest_gap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

VICTIMS: dict[str, Callable[[RunningCloud], psutil.Process]] = {
    "router": RunningCloud.router,
    "container": RunningCloud.container,
    "agent": RunningCloud.agent,
}


async def test_a_robot_is_served_again_after_each_process_froze(
    cloud: RunningCloud, office_map: GridMap, record_property: Callable[[str, object], None]
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=30)
    goals = [reachable_pose(office_map, start, seed=40, at_least=2.5, at_most=4.0), start]
    token = await register_robot(rest, "f", "office", start)
    async with driving(cloud.url, token, "f", office_map, start) as drive:
        for number, (name, find) in enumerate(VICTIMS.items()):
            before = len(drive.commands)
            await drive.send(goals[number % 2], goal_id=name)
            await until(lambda n=before: len(drive.commands) > n + 5)
            await freeze(find(cloud))
        results = [await drive.result()]
        while results[-1].status.goal_id.id != "agent":
            results.append(await drive.result())
        assert [result.status.goal_id.id for result in results] == list(VICTIMS), "one result a goal"
        assert results[-1].status.status == Status.SUCCEEDED, results[-1].status.text
        assert drive.scorer.error(0, goals[0]) <= 0.25
        assert drive.robot.connections == 1, "the robot's socket was kept open"
    record_property("longest_gap_s", longest_gap(drive))
    assert longest_gap(drive) <= SERVED_AGAIN


async def freeze(process: psutil.Process) -> None:
    """Stop a process, and wait until it and its child processes have ended."""
    below = process.children(recursive=True)
    os.kill(process.pid, signal.SIGSTOP)
    await until(lambda: not any(lives(p) for p in (process, *below)), timeout=20.0)
