"""Robots that drive by the traffic of their map: they exchange their places in a lane, and its node may die."""

import asyncio
import os
import signal
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.sim.simulator import Simulator
from robots.sim.world import World
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

MAP = "lane"
LANE = walled_map(7.0, 3.0, [(0.1, 1.4, 2.6, 2.9), (4.4, 1.4, 6.9, 2.9)])
"""A lane in which two robots cannot pass each other, with a bay in the middle."""

WEST, EAST = Pose2D(0.8, 0.75, 0.0), Pose2D(6.2, 0.75, 3.1)


@asynccontextmanager
async def lane(cloud: RunningCloud, rest: RestClient, starts: dict[str, Pose2D]) -> AsyncIterator[dict[str, Drive]]:
    """Connect robots with traffic in one simulated world."""
    await publish_map(rest, MAP, LANE)
    world = World(LANE, 1)
    async with AsyncExitStack() as stack:
        drives = {}
        simulation = asyncio.create_task(Simulator(world).run())
        stack.callback(simulation.cancel)
        for name, pose in starts.items():
            file = RobotFile(map=MAP, initial_pose=(pose.x, pose.y, pose.theta), cores=0.25, traffic=True)
            await rest.put_robot(name, file)
            drives[name] = await stack.enter_async_context(
                driving(cloud.url, str(rest.token), name, LANE, pose, shared=world)
            )
        yield drives


async def states(rest: RestClient) -> dict[str, str]:
    """Return the states of the robots of the traffic, by robot."""
    traffic = await rest.get(f"/v1/maps/{MAP}/traffic")
    return {each["robot"]: each["state"] for each in traffic["robots"]}


async def exchange(drives: dict[str, Drive]) -> None:
    """Send two robots to each other's ends of the lane, and wait until both are there."""
    one, other = drives.values()
    await asyncio.gather(one.send(EAST, "east"), other.send(WEST, "west"))
    results = await asyncio.gather(one.result(150.0), other.result(150.0))
    assert [each.status.status for each in results] == [Status.SUCCEEDED] * 2, [r.status.text for r in results]


async def kill_node(rest: RestClient) -> None:
    """Kill the container of the traffic node."""
    (container,) = [each for each in await rest.items("/v1/containers") if each["kind"] == "traffic"]
    os.kill(container["pid"], signal.SIGKILL)


async def test_robots_exchange_their_places_in_a_lane_while_the_traffic_node_dies(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    async with lane(cloud, rest, {"tw": WEST, "te": EAST}) as drives:
        world = drives["tw"].world
        await until(lambda: _both(drives))
        killed = asyncio.get_running_loop().call_later(10.0, lambda: asyncio.ensure_future(kill_node(rest)))
        await exchange(drives)
        killed.cancel()
        assert world.contacts.robot_contacts.total() == 0
        assert set(await states(rest)) == {"tw", "te"}


def _both(drives: dict[str, Drive]) -> bool:
    return all(drive.poses for drive in drives.values())
