"""Faults of a robot with ROS 2: its bridge is killed, its network is gone, and it restarts elsewhere.

The robot is over Zenoh. Both connections of its bridge pass a forwarder that can be cut.
A clone waits for 12 s, so that outages are as those of 5 s and of 5 min with its usual 30 s.
"""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractContextManager, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from subprocess import Popen

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.network.forwarder import Forwarder
from tests.support.ros2.bridge_process import bridge_process
from tests.support.ros2.zenoh_peer import Recorder
from tests.support.ros2.zenoh_robot import free_endpoint, zenoh_robot
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

LINGER = 12.0


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a cloud whose clones wait for a short time."""
    with running_cloud(tmp_path_factory.mktemp("cloud"), "--linger", str(LINGER)) as running:
        yield running


@dataclass
class Site:
    """A robot's site: the ways to the cloud and to the robot, and the command of the bridge between them."""

    to_cloud: Forwarder
    to_robot: Forwarder
    options: tuple[str, ...]
    log: Path

    def bridge(self) -> AbstractContextManager[Popen[bytes]]:
        """Start the bridge."""
        return bridge_process(*self.options, log=self.log)

    @property
    def endpoint(self) -> str:
        """Endpoint to which the robot connects."""
        return self.to_robot.url.replace("http://", "tcp/")


@asynccontextmanager
async def site(cloud: RunningCloud, robot: str, grid: GridMap, start: Pose2D, folder: Path) -> AsyncIterator[Site]:
    rest = await cloud.admin()
    await publish_map(rest, "office", grid)
    token = await register_robot(rest, robot, "office", start)
    endpoint = free_endpoint()
    async with Forwarder(cloud.url) as to_cloud, Forwarder(endpoint.replace("tcp/", "http://")) as to_robot:
        options = (robot, "--transport", "zenoh", "--listen", endpoint, "--url", to_cloud.url, "--token", token)
        yield Site(to_cloud, to_robot, options, folder / "log")


async def test_a_goal_goes_on_after_each_short_fault(cloud: RunningCloud, office_map: GridMap, tmp_path: Path) -> None:
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=33, at_least=5.0, at_most=9.0)
    async with site(cloud, "short", office_map, start, tmp_path) as there:
        with there.bridge() as bridge:
            async with zenoh_robot(there.endpoint, office_map, start) as robot:
                await robot.send_goal(goal)
                for way in (there.to_cloud, there.to_robot):
                    await way.cut()
                    await robot.stands()
                    await way.mend()
                    await robot.drives()
                bridge.kill()
                bridge.wait()
                await robot.stands()
                with there.bridge():
                    await robot.drives()
                    await robot.arrives(goal)


async def test_a_robot_is_localized_where_it_stands_after_a_long_outage(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=33, at_least=5.0, at_most=9.0)
    async with site(cloud, "long", office_map, start, tmp_path) as there:
        with there.bridge():
            async with zenoh_robot(there.endpoint, office_map, start) as robot:
                await robot.send_goal(goal)
                await asyncio.sleep(4.0)
                await there.to_cloud.cut()
                await robot.stands()
                assert robot.pose.distance_to(start) > 1.0
                await asyncio.sleep(LINGER + 2.0)
                poses = Recorder()
                await there.to_cloud.mend()
                robot.operator.subscribe("amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped", poses)
                await robot.send_goal(goal)
                await robot.arrives(goal)


async def test_a_robot_that_restarts_elsewhere_is_localized_anew(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    start = free_pose(office_map, seed=31)
    elsewhere = reachable_pose(office_map, start, seed=41, at_least=4.0, at_most=9.0)
    goal = reachable_pose(office_map, elsewhere, seed=42, at_least=2.0, at_most=4.0)
    async with site(cloud, "carried", office_map, start, tmp_path) as there:
        with there.bridge():
            async with zenoh_robot(there.endpoint, office_map, start) as robot:
                await robot.send_goal(reachable_pose(office_map, start, seed=32, at_least=1.0, at_most=2.0))
                await there.to_robot.cut()  # it dies without a word
            await there.to_robot.mend()
            async with zenoh_robot(there.endpoint, office_map, elsewhere) as robot:
                poses = Recorder()
                robot.operator.subscribe("amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped", poses)
                await robot.send_goal(goal)
                await robot.arrives(goal)
        assert "the robot has restarted" in there.log.read_text()
