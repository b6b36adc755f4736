"""A standby takes over from a leader that is killed, and from one that is stopped: robots keep their containers.

The clock of the standby's host is an hour ahead, where the library for that is installed.
"""

import asyncio
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.harness.free_ports import free_ports
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.joined_machine import JoinedMachine, container_of, machines, ticket
from tests.support.cloud.shifted_clock import an_hour_ahead
from tests.support.cloud.standby_process import standing_by
from tests.support.engine.processes import has_ended
from tests.support.network.wire import Wire, wire_to
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ROBOT, THERE = "survivor", "m2"


async def drives(drive: Drive, goal: Pose2D, goal_id: str) -> None:
    """Send a goal, and wait until the robot drives."""
    driven = drive.scorer.distance(0)
    await drive.send(goal, goal_id=goal_id)
    await until(lambda: drive.scorer.distance(0) > driven + 0.2, 30.0)


async def finds_its_clone(drive: Drive, wire: Wire, cloud: RunningCloud, pid: int, goal_id: str) -> None:
    """Assert that a robot that comes to a new leader has its container and its goal, which ends once."""
    connections = drive.robot.connections
    wire.mend(cloud.url)
    await until(lambda: drive.robot.connections > connections, 40.0)
    rest = await cloud.admin()
    after = await container_of(rest, ROBOT)
    assert (after["pid"], after["machine"]) == (pid, THERE)
    result = await drive.result()
    assert (result.status.goal_id.id, result.status.status) == (goal_id, Status.SUCCEEDED), result.status.text
    assert drive.results.empty(), "one result a goal"
    assert (await container_of(rest, ROBOT))["pid"] == pid
    async with patience(40.0):
        while await machines(rest) != ["local", THERE]:  # a new leader serves before the agent of its own host has come
            await asyncio.sleep(0.05)


async def test_robots_keep_their_clones_when_a_standby_takes_over(
    tmp_path: Path, office_map: GridMap, record_property: Callable[[str, object], None]
) -> None:
    ports, (first, second) = free_ports(4), (tmp_path / "first", tmp_path / "second")
    stores = ("--store", f"sqlite:///{tmp_path / 'store.sqlite'}", "--map-store", f"file:///{tmp_path / 'maps'}")
    common = (*stores, "--cores", "1", "--adopt-within", "12")
    of_first = (*common, "--listen-machines", f"127.0.0.1:{ports[0]}")
    of_second = (*common, "--listen-machines", f"127.0.0.1:{ports[2]}")
    start, joined = free_pose(office_map, seed=32), JoinedMachine(tmp_path / "m2", THERE)
    goal = reachable_pose(office_map, start, seed=42, at_least=1.5, at_most=3.0)
    first.mkdir()
    with running_cloud(first, *of_first) as cloud:
        rest, agent = await cloud.admin(), cloud.agent()
        joined.start(ticket(first / "data"))
        await joined.is_in(rest)
        await rest.patch("/v1/machines/local", {"max_containers": 0})
        await publish_map(rest, "office", office_map)
        token = await register_robot(rest, ROBOT, "office", start)
        invitation = ticket(first / "data", "--standby", "second")
        async with wire_to(cloud.url) as wire, driving(wire.url, token, ROBOT, office_map, start) as drive:
            ahead = an_hour_ahead()
            record_property("clock_of_the_standby", ahead.get("FAKETIME", "right"))
            with standing_by(second, "--standby", invitation, *of_second, environment=ahead) as heir:
                await heir.stands_by()
                await drives(drive, goal, "there")
                pid = (await container_of(rest, ROBOT))["pid"]
                spares = heir.endpoints()
                os.kill(cloud.pid, signal.SIGKILL)
                cloud.status = -signal.SIGKILL
                wire.cut()
                leader = await heir.leads()
                assert heir.endpoints() == spares != [], "it has started them while it stood by"
                await finds_its_clone(drive, wire, leader, pid, "there")
                await until(lambda: has_ended(agent.pid), 30.0)
                with standing_by(first, "--standby", *of_first) as again:
                    await again.stands_by()
                    await drives(drive, start, "back")
                    os.kill(leader.pid, signal.SIGSTOP)
                    wire.cut()
                    await finds_its_clone(drive, wire, await again.leads(), pid, "back")
                    os.kill(leader.pid, signal.SIGCONT)
                    assert await heir.has_ended() == 1
                    assert "another process leads this cloud now" in heir.log.read_text()
                    await asyncio.sleep(0.5)
                    assert (await container_of(await (await again.leads()).admin(), ROBOT))["pid"] == pid
                    joined.end()
