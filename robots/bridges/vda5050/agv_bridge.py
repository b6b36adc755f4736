"""Robot of the cloud as an AGV: its clone on one side, the broker on the other."""

import asyncio
import logging
from collections.abc import Coroutine
from typing import Any
from uuid import uuid4

from ppaas.errors import PPaaSError, Unavailable
from ppaas.robot_model.known_models import robot_model
from ppaas.wire.vda5050.agv.agv import Abilities, Agv
from ppaas.wire.vda5050.agv.commands import Command, SendFactsheet, UseZones
from ppaas.wire.vda5050.agv.report import Telemetry
from ppaas.wire.vda5050.agv.zone_book import SUPPORTED
from ppaas.wire.vda5050.states import Information, PowerSupply
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.broker import Broker
from robots.bridges.vda5050.clone_side import CloneSide
from robots.bridges.vda5050.factsheet import factsheet_of
from robots.bridges.vda5050.fleet_side import FleetSide
from robots.bridges.vda5050.mqtt_link import MqttLink
from robots.bridges.vda5050.zone_masks import ZoneMasks
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

logger = logging.getLogger(__name__)

LOOK_PERIOD = 0.1
"""Time between two looks at what is due [s]."""

MAX_COMMANDS = 1000
"""Largest number of commands that wait for the clone."""

MAINS = 100.0
"""Charge that is reported of a robot that says nothing of its battery [%]."""


class AgvBridge:
    """Presents one robot as an AGV.

    Parameters
    ----------
    url, token : str
        URL of the cloud, and token of a user who may drive the robot.
    robot : str
        Id of the robot; ``OWNER:ID`` for one of another user.
    broker : Broker
    options : AgvOptions
    """

    def __init__(self, url: str, token: str, robot: str, broker: Broker, options: AgvOptions) -> None:
        self._url, self._token, self._robot, self._broker, self._options = url, token, robot, broker, options
        self._rest = RestClient(url, token)
        self._commands: asyncio.Queue[Command] = asyncio.Queue(MAX_COMMANDS)
        self._tasks: set[asyncio.Task[None]] = set()
        self._link: CloudLink | None = None
        self._clone: CloneSide | None = None

    async def run(self) -> None:
        """Present the robot until cancelled.

        Raises
        ------
        PPaaSError
            The cloud or the broker refuses the bridge, and why.
        """
        robot = await self._rest.get(path_of("robots", self._robot))
        map_id = str(robot["map"])
        zones = SUPPORTED if self._options.zones else ()
        self._agv = Agv(self._options.version, Abilities(map_id, frozenset(self._options.services), zones))
        self._masks = ZoneMasks(self._rest, self._robot, robot_model(str(robot["model"])).robot_radius)
        if self._options.zones:
            await self._masks.prepare(robot["parameters"])
        unknown = Information(
            info_type="batteryUnknown", info_level="INFO", info_descriptor="the robot publishes no battery_state"
        )
        power = PowerSupply(state_of_charge=MAINS, charging=False)
        telemetry = Telemetry(power, map_version=await self._map_version(map_id), information=[unknown])
        self._fleet = FleetSide(
            self._agv,
            telemetry,
            factsheet_of(robot, self._options),
            map_id=map_id,
            serial=self._robot,
            options=self._options,
        )
        mqtt = MqttLink(self._broker, f"ppaas-{uuid4().hex[:16]}", self._fleet.exchange(self._changed))
        self._fleet.use(mqtt.outbox)
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(mqtt.run())
                group.create_task(self._follow_clone(telemetry))
        except* PPaaSError as errors:
            raise errors.exceptions[0] from None
        finally:
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _map_version(self, map_id: str) -> str:
        try:
            return str((await self._rest.get(path_of("maps", map_id)))["version"])
        except PPaaSError as error:
            logger.info("the version of map %s is not reported: %s", map_id, error)
            return ""

    async def _follow_clone(self, telemetry: Telemetry) -> None:
        """Stay connected to the robot's clone, which is there while the robot is."""
        while True:
            link = self._link = CloudLink(self._url, robot=self._robot, token=self._token, operator=True)
            clone = CloneSide(self._agv, telemetry, link, self._options, changed=self._changed, start=self._start)
            self._clone = clone
            try:
                async with link:
                    logger.info("AGV %s is connected to its robot", self._robot)
                    await clone.subscribe()
                    executing = asyncio.create_task(self._execute(clone))
                    try:
                        await link.closed()
                    finally:
                        executing.cancel()
            except Unavailable as error:
                logger.info("AGV %s waits for its robot: %s", self._robot, error)

    def look(self) -> None:
        """Do what is due: notice losses, and publish states."""
        if self._clone is not None:
            self._clone.check()
            self._fleet.publish_due()

    def _changed(self) -> None:
        for command in self._agv.take_commands():
            if isinstance(command, SendFactsheet):
                self._fleet.send_factsheet()
            elif isinstance(command, UseZones):
                self._start(self._use_zones(command.zone_set_id))
            elif self._commands.full():
                logger.error("AGV %s: the cloud takes no commands; one is dropped: %s", self._robot, command)
            else:
                self._commands.put_nowait(command)
        self._fleet.publish_due()

    async def _execute(self, clone: CloneSide) -> None:
        while True:
            await clone.execute(await self._commands.get())

    async def _use_zones(self, zone_set_id: str) -> None:
        try:
            await self._masks.use(self._agv.zones.get(zone_set_id), self._ask_mask)
        except PPaaSError as error:
            self._agv.zones_used(zone_set_id, str(error))
        else:
            self._agv.zones_used(zone_set_id)
        self._changed()

    async def _ask_mask(self, service: str) -> bytes:
        if self._link is None:
            raise Unavailable("the robot is not connected to the cloud")
        return await self._link.call(service, "nav_msgs/GetMap", b"{}")

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            logger.error("AGV %s: %s", self._robot, task.exception())


async def present(url: str, token: str, robots: list[str], broker: Broker, options: AgvOptions) -> None:
    """Present robots as AGVs until cancelled; one that is refused does not end the others.

    Raises
    ------
    PPaaSError
        All were refused; the first reason.
    """
    bridges = [AgvBridge(url, token, robot, broker, options) for robot in robots]
    looking = asyncio.create_task(_look(bridges))
    try:
        ends = await asyncio.gather(*(_present(bridge, robot) for bridge, robot in zip(bridges, robots, strict=True)))
    finally:
        looking.cancel()
    raise next(error for error in ends if error is not None)


async def _present(bridge: AgvBridge, robot: str) -> PPaaSError | None:
    try:
        await bridge.run()
    except PPaaSError as error:
        logger.error("robot %s is not presented any more: %s", robot, error)
        return error
    return None


async def _look(bridges: list[AgvBridge]) -> None:
    """Run what is due in all bridges; one task for all takes a third of the time of one for each."""
    while True:
        for bridge in bridges:
            bridge.look()
        await asyncio.sleep(LOOK_PERIOD)
