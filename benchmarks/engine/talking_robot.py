"""Standing robot that publishes its pose, which reaches other robots of the map by their containers."""

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

import msgspec

from benchmarks.harness.cloud_under_test import CloudUnderTest
from ppaas.clock import epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from robots.client.robot_client import RobotClient
from robots.sim.world import World

STEP = 0.0005
"""Distance between consecutive odometry messages [m]: their positions identify them at the receiver."""

SAME_STAMP = 1e-5
"""Largest difference between equal stamps [s], which are rounded to floats on the way."""

PATIENCE = 1.0
"""Time after which a message counts as lost [s]; messages between robots may be lost."""

LONGEST_SILENCE = 10.0
"""Time within which a clone publishes the pose of a scan [s], also on a busy computer: none is lost."""


@dataclass(slots=True)
class ReceivedPositions:
    """Messages received on a topic: arrival time [monotonic s], and x of one or several robots [m]."""

    times: deque[tuple[float, list[float]]] = field(default_factory=lambda: deque(maxlen=100))
    news: asyncio.Event = field(default_factory=asyncio.Event)

    def note(self, *positions: float) -> None:
        """Record positions that arrive now [m]."""
        self.times.append((monotonic(), list(positions)))
        self.news.set()

    async def of(self, x: float) -> float | None:
        """Return the arrival time of a position [monotonic s]; None if it does not arrive within the time limit."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(PATIENCE):
                while True:
                    for time, positions in self.times:
                        if any(abs(position - x) < STEP / 10.0 for position in positions):
                            return time
                    self.news.clear()
                    await self.news.wait()
        return None


class TalkingRobot:
    """A standing robot with a container.

    Parameters
    ----------
    client : RobotClient
        Its open connection.
    odometry, scan : Odometry, LaserScan
        Messages of its sensors.

    Attributes
    ----------
    others : ReceivedPositions
        Positions of other robots, received from its clone.
    """

    def __init__(self, client: RobotClient, odometry: Odometry, scan: LaserScan) -> None:
        self._client = client
        self._odometry = odometry
        self._scan = scan
        self._said = 0
        self._poses: asyncio.Queue[tuple[float, PoseWithCovarianceStamped]] = asyncio.Queue()
        self.others = ReceivedPositions()

    async def listen(self) -> None:
        """Subscribe to the poses of this robot and of the others."""
        await self._client.subscribe("amcl_pose", PoseWithCovarianceStamped, self._located)
        await self._client.subscribe("robots", RobotStates, self._told)

    def _located(self, pose: PoseWithCovarianceStamped) -> None:
        self._poses.put_nowait((monotonic(), pose))

    def _told(self, poses: RobotStates) -> None:
        self.others.note(*(pose.position.x for pose in poses.poses))

    async def say(self) -> tuple[float, float]:
        """Publish a new position; return the arrival time of the clone's pose [monotonic s], and its x [m].

        Raises
        ------
        Unavailable
            The clone publishes no pose within the time limit.
        """
        self._said += 1
        stamp = Time.of(epoch())
        await self._client.publish("odom", _moved(self._odometry, self._said * STEP, stamp))
        await self._client.publish("scan", msgspec.structs.replace(self._scan, header=_at(self._scan.header, stamp)))
        try:
            async with asyncio.timeout(LONGEST_SILENCE):
                while True:
                    time, pose = await self._poses.get()
                    if abs(pose.header.stamp.seconds() - stamp.seconds()) < SAME_STAMP:
                        return time, pose.pose.pose.position.x
        except TimeoutError as error:
            raise Unavailable(f"a clone published no pose for {LONGEST_SILENCE:g} s after a scan") from error


def _at(header: Header, stamp: Time) -> Header:
    return msgspec.structs.replace(header, stamp=stamp)


def _moved(odometry: Odometry, x: float, stamp: Time) -> Odometry:
    replace = msgspec.structs.replace
    pose = odometry.pose.pose
    there = replace(pose, position=replace(pose.position, x=pose.position.x + x))
    return replace(odometry, header=_at(odometry.header, stamp), pose=replace(odometry.pose, pose=there))


@contextlib.asynccontextmanager
async def talking_robot(
    target: CloudUnderTest, robot: str, map_id: str, grid: GridMap, start: Pose2D
) -> AsyncIterator[TalkingRobot]:
    """Open a robot that stands at a pose of a published map."""
    await target.register(robot, map_id, start)
    body = World(grid, 1).add_robot(start)
    async with RobotClient(target.url, robot=robot, token=target.token) as client:
        speaker = TalkingRobot(client, body.odometry(), body.scan())
        await speaker.listen()
        yield speaker
