"""A robot that sends scans and no odometry: the cloud maps, and drives it once odometry comes."""

import asyncio

import numpy as np
import pytest

from ppaas.maps.grid import UNKNOWN, GridMap
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.e2e.test_new_map import map_of, wrong_parts
from tests.support.cloud.cloud import RunningCloud
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ROBOT = "handheld"


class WithoutWheels(RobotClient):
    """Client of a robot whose odometry is not connected."""

    wheels = False

    async def publish(self, topic: str, message: Message, *, newest_only: bool = False) -> None:
        """Publish a message, but no odometry."""
        if topic != "odom" or self.wheels:
            await super().publish(topic, message, newest_only=newest_only)


async def push(drive: Drive, speed: float, turn: float, seconds: float) -> None:
    """Move the robot as a person would, who pushes it."""
    for _ in range(round(5.0 * seconds)):
        drive.world.robots[0].command(Twist(Vector3(x=speed), Vector3(z=turn)))
        await asyncio.sleep(0.2)


async def test_scans_alone_are_mapped_until_odometry_comes(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    start = free_pose(office_map, seed=4)
    await rest.put_robot(ROBOT, RobotFile(map="new:handheld", parameters={"amcl": {"max_particles": 900}}))
    assert rest.token is not None
    statuses: list[str] = []
    async with driving(cloud.url, rest.token, ROBOT, office_map, start, client=WithoutWheels) as drive:
        robot = drive.world.robots[0]
        await drive.operator.subscribe("grid_slam/status", String, lambda message: statuses.append(message.data))
        await until(lambda: any("scans alone" in each for each in statuses), 60)
        for _ in range(6):
            await push(drive, 0.0, 0.5, 2.0)
            await push(drive, 0.15, 0.3, 2.0)
        await push(drive, 0.0, 0.0, 1.0)
        assert sum("scans alone" in each for each in statuses) == 1, "it is said once"
        assert robot.base.pose.distance_to(start @ drive.estimate()) < 0.05

        state = await rest.get(f"/v1/robots/{ROBOT}/state")
        assert "scans alone" in state["localization"] and state["pose"] is not None
        findings = (await rest.get(f"/v1/robots/{ROBOT}/diagnosis"))["findings"]
        assert "maps-without-odometry" in [finding["kind"] for finding in findings]
        goal = reachable_pose(office_map, robot.base.pose, 1, at_least=1.0, at_most=2.0)
        await drive.send(start.inverse() @ goal, "early")
        await until(lambda: any("scans alone" in each.text for each in drive.status.status_list), 10)

        before = drive.estimate()
        assert isinstance(drive.robot, WithoutWheels)
        drive.robot.wheels = True
        await until(lambda: statuses[-1] == "", 10)
        assert drive.estimate().distance_to(before) < 0.1
        await drive.result()
        assert robot.base.pose.distance_to(goal) <= 0.25
        assert robot.base.pose.distance_to(start @ drive.estimate()) <= 0.1
        made = await map_of(drive.operator)
        assert np.sum(made.data != UNKNOWN) > 5_000
        occupied, free = wrong_parts(made, office_map, start)
        assert occupied <= 0.02
        assert free <= 0.01
