"""Two robots without a common start: the cloud joins their maps while they drive, and a killed container keeps it."""

import asyncio
import contextlib
import math

import pytest

from benchmarks.mapping.simulated_drive import SimulatedDrive
from ppaas.clock import epoch
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.transforms.planar import transform_message
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud
from tests.support.waiting import PATIENCE, patience, until
from tests.support.world.merge_drives import first_drive, second_drive

pytestmark = pytest.mark.journey

PERIOD = 0.02
"""Time between two scans, ten times as fast as the robots drove [s]."""


class Playback:
    """Robot that sends the scans and the odometry of a simulated drive."""

    def __init__(self, robot: RobotClient, drive: SimulatedDrive) -> None:
        self._robot, self.drive, self.sent = robot, drive, 0

    async def play(self, until: int) -> None:
        """Send the scans before an index."""
        mount = transform_message("base_link", "laser", self.drive.log.geometry.mount, Time())
        await self._robot.publish("tf_static", TFMessage([mount]))
        for number in range(until):
            self.sent = number
            await self.send(number)
            await asyncio.sleep(PERIOD)

    async def stand(self) -> None:
        """Send the last scan again and again."""
        while True:
            await self.send(self.sent)
            await asyncio.sleep(0.1)

    async def send(self, number: int) -> None:
        log, stamp = self.drive.log, Time.of(epoch())
        geometry = log.geometry
        odometry = transform_message("odom", "base_link", Pose2D(*log.odometry[number].tolist()), stamp)
        await self._robot.publish("tf", TFMessage([odometry]))
        ranges = [None if math.isnan(value) else value for value in log.ranges[number].tolist()]
        last = geometry.angle_min + geometry.angle_increment * (geometry.beams - 1)
        header = Header(stamp=stamp, frame_id="laser")
        scan = LaserScan(header, geometry.angle_min, last, geometry.angle_increment, 0.05, 30.0, ranges)
        await self._robot.publish("scan", scan)

    @property
    def true(self) -> Pose2D:
        return Pose2D(*self.drive.true[self.sent].tolist())


async def joined(rest: RestClient, robot: str, others: list[str]) -> dict[str, object]:
    """Wait until a robot's map is one with those of others; return its size."""
    async with patience(2.0 * PATIENCE):  # a program of low priority joins them
        while True:
            with contextlib.suppress(Unavailable):
                shown = dict(await rest.get(f"/v1/robots/{robot}/map"))
                if shown["joined_with"] == others:
                    return shown
            await asyncio.sleep(0.2)


async def pose_of(rest: RestClient, robot: str) -> Pose2D:
    return Pose2D(*(await rest.get(f"/v1/robots/{robot}/state"))["pose"])


async def test_two_robots_become_one_map_while_they_drive(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    assert rest.token is not None
    for name in ("north", "south"):
        await rest.put_robot(name, RobotFile(map="new:ring"))
    async with (
        RobotClient(cloud.url, robot="north", token=rest.token) as north,
        RobotClient(cloud.url, robot="south", token=rest.token) as south,
    ):
        robots = Playback(north, first_drive()), Playback(south, second_drive())
        await asyncio.gather(*(robot.play(330) for robot in robots))
        standing = [asyncio.create_task(robot.stand()) for robot in robots]
        try:
            shown = await joined(rest, "north", ["south"])
            await joined(rest, "south", ["north"])
            await asyncio.sleep(1.0)
            poses = [await pose_of(rest, name) for name in ("north", "south")]
            between = [first.inverse() @ second for first, second in (poses, [robot.true for robot in robots])]
            assert between[0].distance_to(between[1]) < 0.2
            killed = cloud.container()
            killed.kill()
            await until(lambda: cloud.container().pid != killed.pid)
            for name, other in (("north", "south"), ("south", "north")):
                again = await joined(rest, name, [other])
                assert int(str(again["key_frames"])) >= int(str(shown["key_frames"])) - 1
        finally:
            for task in standing:
                task.cancel()
            await asyncio.gather(*standing, return_exceptions=True)
