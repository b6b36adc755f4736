"""A robot is connected while its own socket is open: after losses of robots, endpoints, masters and networks.

The kind: the life of a container, which waits for a robot that left, is taken for the presence of the robot.
"""

import asyncio
import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from ppaas.errors import Unavailable
from ppaas.maps.grid import GridMap
from ppaas.messages.base.std_msgs import Bool
from ppaas.wire.own_topics import PRESENCE
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.faults.test_endpoints import endpoints, served_by
from tests.faults.test_master_restart import ADOPTED
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.network.wire import Wire, wire_to
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

LINGERS = ("--linger", "300", "--dead", "3")
"""Options of clouds in which containers wait far longer than the tests take, and dead sockets are noticed soon."""


@asynccontextmanager
async def robot_of(cloud: RunningCloud, grid: GridMap, name: str) -> AsyncIterator[tuple[RobotClient, Wire]]:
    """Connect a robot over a wire that can be cut."""
    rest = await cloud.admin()
    await publish_map(rest, "office", grid)
    token = await register_robot(rest, name, "office", free_pose(grid, seed=32))
    async with wire_to(cloud.url) as wire, RobotClient(wire.url, robot=name, token=token) as robot:
        yield robot, wire


async def state_of(rest: RestClient, name: str) -> dict[str, Any]:
    found: dict[str, Any] = await rest.get(path_of("robots", name, "state"))
    return found


async def becomes(rest: RestClient, name: str, *, connected: bool) -> dict[str, Any]:
    """Wait until a robot is connected, or not; its container waits for it. All that shows it says the same."""
    async with patience(60.0):
        while (state := await state_of(rest, name))["connected"] != connected:
            await asyncio.sleep(0.05)
    assert (state["disconnected_since"] is None) == connected
    [container] = [one for one in await rest.items("/v1/containers") if one["robot"] == name]
    [robot] = [one for one in await rest.items("/v1/robots") if one["id"] == name]
    assert state["container"] and container["connected"] == robot["connected"] == connected
    return state


async def test_a_robot_that_leaves_is_cut_off_or_falls_silent_is_not_connected(
    tmp_path: Path, office_map: GridMap
) -> None:
    with running_cloud(tmp_path, "--endpoints", "2", *LINGERS) as cloud:
        rest, heard = await cloud.admin(), list[bool]()
        async with robot_of(cloud, office_map, "tb1") as (_, wire):
            await becomes(rest, "tb1", connected=True)
            async with RobotClient(cloud.url, robot="tb1", token=cloud.token, role="operator") as operator:
                await operator.subscribe(PRESENCE, Bool, lambda message: heard.append(message.data))
                wire.cut()
                await becomes(rest, "tb1", connected=False)
                with pytest.raises(Unavailable, match="robot 'tb1' is not connected"):
                    await rest.post(path_of("robots", "tb1", "goals"), {"pose": [1.0, 1.0, 0.0]})
                wire.mend()
                await becomes(rest, "tb1", connected=True)
                wire.stall()  # half open: nothing is closed, and pings are not answered
                await becomes(rest, "tb1", connected=False)
                wire.flow()
                await becomes(rest, "tb1", connected=True)
                await until(lambda: heard == [True, False, True, False, True], 10.0)
                lost = served_by(cloud).pid
                os.kill(lost, signal.SIGKILL)
                await until(lambda: lost not in [process.pid for process in endpoints(cloud)], 30.0)
            await becomes(rest, "tb1", connected=True)
        await becomes(rest, "tb1", connected=False)
        await rest.delete(path_of("robots", "tb1"))  # its container, which waited, ends


async def test_presence_is_right_after_another_master_has_taken_over(tmp_path: Path, office_map: GridMap) -> None:
    options = (*LINGERS, *ADOPTED)
    with running_cloud(tmp_path, *options) as first:
        rest = await first.admin()
        async with robot_of(first, office_map, "gone"):
            await becomes(rest, "gone", connected=True)
        await becomes(rest, "gone", connected=False)
        async with robot_of(first, office_map, "here") as (robot, wire):
            await becomes(rest, "here", connected=True)
            os.kill(first.pid, signal.SIGKILL)
            first.status = -signal.SIGKILL
            wire.cut()
            (tmp_path / "ready.json").unlink()
            with running_cloud(tmp_path, *options) as second:
                wire.mend(second.url)
                await until(lambda: robot.connections > 1, 60.0)
                again = await second.admin()
                for name, connected in (("here", True), ("gone", False)):
                    state = await state_of(again, name)
                    assert (state["connected"], state["container"]) == (connected, True), name
