"""Robot of the cloud as a robot with Navigation2, as far as free_fleet uses it: tf, battery, and goals to poses."""

import asyncio
import logging
from collections.abc import Coroutine
from functools import partial
from typing import Any, NoReturn

from ppaas.clock import epoch, monotonic
from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import decode
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.wire.ros.graph import Qos
from robots.bridges.core.actions import ActionServer
from robots.bridges.core.battery import charge_of
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.core.frames import Frames
from robots.bridges.core.notices import Notices
from robots.bridges.core.parts import BridgeParts, RobotTime
from robots.bridges.core.transport import Transport

logger = logging.getLogger(__name__)

POSE_PERIOD = 0.2
"""Least time between two transforms [s]."""

BATTERY_PERIOD = 1.0
"""Least time between two messages of the battery [s]."""

NAVIGATE = "nav2_msgs/action/NavigateToPose"
TF, BATTERY = "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/BatteryState"


class FreeFleetRobot:
    """One robot.

    Parameters
    ----------
    transport : Transport
        Session that free_fleet reaches.
    url, token : str
        URL of the cloud, and token of a user who may drive the robot.
    robot, name : str
        Id of the robot in the cloud, and its name in RMF, which is the namespace of its topics.
    frame : str
        Name of its body's frame.
    """

    def __init__(self, transport: Transport, url: str, token: str, *, robot: str, name: str, frame: str) -> None:
        self._transport, self._url, self._token = transport, url, token
        self._robot, self._name, self._frame = robot, name, frame
        self._time = RobotTime(monotonic, epoch)
        self._notices = Notices()
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> NoReturn:
        """Present the robot until cancelled.

        Raises
        ------
        PPaaSError
            The cloud refuses the token for this robot, and why.
        """
        tf = self._transport.publisher(f"/{self._name}/tf", TF, Qos())
        battery = self._transport.publisher(f"/{self._name}/battery_state", BATTERY, Qos())
        while True:
            link = CloudLink(self._url, robot=self._robot, token=self._token, operator=True)
            try:
                async with link:
                    logger.info("robot %s is presented to free_fleet", self._name)
                    kind = "geometry_msgs/PoseWithCovarianceStamped"
                    await link.subscribe("amcl_pose", kind, partial(self._posed, tf.publish), period=POSE_PERIOD)
                    await link.subscribe(
                        "battery_state", BATTERY, partial(self._charged, battery.publish), period=BATTERY_PERIOD
                    )
                    await self._serve(link)
            except Unavailable as error:
                logger.info("robot %s is awaited: %s", self._name, error)

    async def _serve(self, link: CloudLink) -> None:
        """Offer the action until the link ends."""
        parts = BridgeParts(self._transport, link, Frames(), self._time, self._notices, monotonic, self._start)
        action = ActionServer("navigate_to_pose", NAVIGATE, f"/{self._name}/navigate_to_pose", parts)
        try:
            await link.closed()
        finally:
            action.close()

    def _posed(self, publish: Any, message: bytes) -> None:
        pose = decode(PoseWithCovarianceStamped, message).pose.pose
        place, turn = pose.position, pose.orientation
        transform = {
            "header": {"stamp": self._time.now(), "frame_id": "map"},
            "child_frame_id": self._frame,
            "transform": {
                "translation": {"x": place.x, "y": place.y, "z": place.z},
                "rotation": {"x": turn.x, "y": turn.y, "z": turn.z, "w": turn.w},
            },
        }
        publish(self._transport.types.encode(TF, {"transforms": [transform]}))

    def _charged(self, publish: Any, message: bytes) -> None:
        if charge_of(message) is not None:
            publish(self._transport.types.encode_json(BATTERY, message))

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and isinstance(error := task.exception(), PPaaSError):
            logger.warning("robot %s: %s", self._name, error)


async def present(transport: Transport, url: str, token: str, robots: dict[str, str], frame: str) -> None:
    """Present robots, with their names in RMF, until cancelled; one that is refused does not end the others.

    Raises
    ------
    PPaaSError
        All were refused, or the transport cannot be opened, and why.
    """
    await transport.open(lambda: None)
    try:
        presented = {
            name: FreeFleetRobot(transport, url, token, robot=robot, name=name, frame=frame)
            for robot, name in robots.items()
        }
        ends = await asyncio.gather(*map(_refusal_of, presented.items()))
    finally:
        await transport.close()
    raise ends[0]


async def _refusal_of(presented: tuple[str, FreeFleetRobot]) -> PPaaSError:
    name, robot = presented
    try:
        await robot.run()
    except PPaaSError as error:
        logger.error("robot %s is not presented any more: %s", name, error)
        return error
