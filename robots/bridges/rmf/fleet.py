"""Fleet for Open-RMF: states out, requests in, over a transport of ROS 2."""

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError
from ppaas.wire.rmf.fleet_robot import FleetRobot
from ppaas.wire.rmf.level_frame import LevelFrame
from ppaas.wire.rmf.requests import Request, destination_request, mode_request, path_request
from ppaas.wire.ros.graph import Qos
from ppaas.wire.ros.rmf_definitions import DESTINATION_REQUEST, FLEET_STATE, MODE_REQUEST, PATH_REQUEST
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Publisher, Transport
from robots.bridges.rmf.options import FleetForRmf
from robots.bridges.rmf.robot_in_cloud import RobotInCloud
from robots.bridges.rmf.workcells import WorkcellBridge
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

logger = logging.getLogger(__name__)

LOOK_PERIOD = 0.1
"""Time between two looks at what is due [s]."""

QOS = Qos()
REQUESTS: Mapping[str, tuple[str, Callable[[Mapping[str, Any]], Request]]] = {
    "/robot_path_requests": (PATH_REQUEST, path_request),
    "/robot_mode_requests": (MODE_REQUEST, mode_request),
    "/destination_requests": (DESTINATION_REQUEST, destination_request),
}
"""Topics of requests, with their types."""

STATES = "/fleet_states"


class RmfFleet:
    """Robots of the cloud as a fleet.

    Parameters
    ----------
    transport : Transport
        Node in the graph of Open-RMF.
    url, token : str
        URL of the cloud, and token of a user who may drive the robots.
    options : FleetForRmf
    now : callable
        Clock of Open-RMF [s since the epoch].

    Attributes
    ----------
    workcells : WorkcellBridge, optional
        Bridge of tasks to workcells, which is served, too.
    """

    def __init__(self, transport: Transport, url: str, token: str, options: FleetForRmf, now: Clock = epoch) -> None:
        self.workcells: WorkcellBridge | None = None
        self._transport, self._url, self._token, self._options, self._now = transport, url, token, options, now
        self._robots: dict[str, FleetRobot] = {}
        self._sides: dict[str, RobotInCloud] = {}
        self._notices = Notices()
        self._published, self._changed = float("-inf"), True

    async def run(self) -> None:
        """Serve the fleet until cancelled.

        Raises
        ------
        PPaaSError
            The cloud refuses a robot, or the transport cannot be opened, and why.
        """
        await self._transport.open(lambda: None)
        try:
            states = self._transport.publisher(STATES, FLEET_STATE, QOS)
            for topic, (kind, read) in REQUESTS.items():
                self._transport.subscribe(topic, kind, QOS, partial(self._received, kind, read))
            async with asyncio.TaskGroup() as group:
                group.create_task(self._look(states))
                group.create_task(self._transport.ended())
                group.create_task(self._follow())
                if self.workcells is not None:
                    group.create_task(self.workcells.serve(self._transport))
        except* PPaaSError as errors:
            raise errors.exceptions[0] from None
        finally:
            await self._transport.close()

    async def _follow(self) -> None:
        """Follow all robots; one that is refused does not end the others."""
        ends = await asyncio.gather(*map(self._refusal_of, self._sides.items()))
        raise ends[0]

    async def _refusal_of(self, followed: tuple[str, RobotInCloud]) -> PPaaSError:
        name, side = followed
        try:
            await side.run()
        except PPaaSError as error:
            logger.error("robot %s is not in the fleet any more: %s", name, error)
            self._robots[name].pose = None
            return error

    def add(self, robot: str, record: Mapping[str, Any]) -> None:
        """Add a robot by its id and its record in the cloud.

        Raises
        ------
        NotFound
            There are reference points, but none for its level.
        Conflict
            Another robot of the fleet has its name.
        """
        name = self._options.names.get(robot, robot)
        level = self._options.levels.get(record["map"], record["map"])
        frame = self._options.frames.get(level)
        if frame is None and self._options.frames:
            known = list(self._options.frames)
            raise NotFound("level with reference points", level, known, advice=f"robot {robot} is on it")
        if name in self._robots:
            raise Conflict(f"two robots would be {name!r} in the fleet: give one another name by --name")
        made = FleetRobot(name, record["model"], level, frame or LevelFrame())
        self._robots[name] = made
        link = partial(CloudLink, self._url, robot=robot, token=self._token, operator=True)
        self._sides[name] = RobotInCloud(made, link, self._now)

    # -- requests ------------------------------------------------------------------------------------------------------

    def _received(self, kind: str, read: Callable[[Mapping[str, Any]], Request], data: bytes) -> None:
        try:
            message = self._transport.types.decode(kind, data)
            robot = self._robots.get(message["robot_name"])
            if message["fleet_name"] != self._options.name or robot is None:
                return
            refusal = robot.take(read(message), self._now())
        except PPaaSError as error:
            self._notices.warn(f"a {kind.rpartition('/')[2]} is refused: {error}")
            return
        if refusal or robot.error:
            self._notices.warn(f"robot {robot.name}: {refusal or robot.error}")
        self._changed = True

    # -- states --------------------------------------------------------------------------------------------------------

    async def _look(self, states: Publisher) -> None:
        while True:
            for side in self._sides.values():
                side.look()
            if self._changed or monotonic() - self._published >= self._options.period:
                self._published, self._changed = monotonic(), False
                self._publish(states)
            await asyncio.sleep(LOOK_PERIOD)

    def _publish(self, states: Publisher) -> None:
        seconds = self._now()
        stamp = {"sec": int(seconds), "nanosec": int(seconds % 1.0 * 1e9)}
        robots = [state for robot in self._robots.values() if (state := robot.state(stamp)) is not None]
        message = {"name": self._options.name, "robots": robots}
        states.publish(self._transport.types.encode(FLEET_STATE, message))


async def present(transport: Transport, url: str, token: str, robots: Sequence[str], options: FleetForRmf) -> None:
    """Present robots of the cloud as a fleet until cancelled.

    Raises
    ------
    PPaaSError
        There is no robot, one is unknown, all were refused, or the transport cannot be opened, and why.
    """
    if not robots:
        raise InvalidInput("a fleet needs robots, and the user has none: name some, as OWNER:ID for those of others")
    fleet, rest = RmfFleet(transport, url, token, options), RestClient(url, token)
    records = {robot: await rest.get(path_of("robots", robot)) for robot in robots}
    for robot, record in records.items():
        fleet.add(robot, record)
    fleet.workcells = WorkcellBridge(rest, {record["map"] for record in records.values()}, options.name)
    await fleet.run()
