"""Fleet of AGVs at one broker: finds them by their topics, and makes each a robot of the account."""

import asyncio
import logging
from uuid import uuid4

from ppaas.clock import epoch, monotonic
from ppaas.errors import PPaaSError
from ppaas.listener_faults import ListenerFaults
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode
from ppaas.wire.vda5050.topics import AgvAddress, parse_topic, version_of
from robots.bridges.agv.agv_robot import AgvRobot
from robots.bridges.agv.agv_side import AgvSide
from robots.bridges.agv.options import MAJORS, FleetOptions
from robots.bridges.agv.registration import AgvRegistry
from robots.bridges.agv.zones import ZoneReader
from robots.bridges.vda5050.broker import Broker
from robots.bridges.vda5050.mqtt_link import Exchange, MqttLink
from robots.client.rest import RestClient

logger = logging.getLogger(__name__)

MAX_AGVS = 1000
"""Largest number of AGVs of a bridge."""

TICK = 1.0
"""Time between two looks at what is due [s]."""


class Fleet:
    """All AGVs of a broker, or those that are listed, as robots of one account.

    Parameters
    ----------
    url, token : str
        URL of the cloud, and token of the account.
    broker : Broker
    options : FleetOptions
    """

    def __init__(self, url: str, token: str, broker: Broker, options: FleetOptions) -> None:
        self._url, self._token, self._options = url, token, options
        rest = RestClient(url, token)
        self._zones, self._registry = ZoneReader(rest), AgvRegistry(rest, options)
        exchange = Exchange(filters(options.interface), self.receive, lost=self._broker_lost)
        self.mqtt = MqttLink(broker, f"ppaas-fleet-{uuid4().hex[:12]}", exchange)
        self.robots: dict[AgvAddress, AgvRobot] = {}
        self._group: asyncio.TaskGroup | None = None
        self._ignored: set[AgvAddress] = set()
        self._faults = ListenerFaults(logger)

    async def run(self) -> None:
        """Lead the AGVs until cancelled.

        Raises
        ------
        NotAuthenticated
            The broker refuses the login.
        """
        try:
            async with asyncio.TaskGroup() as group:
                self._group = group
                group.create_task(self.mqtt.run())
                group.create_task(self._tick())
                group.create_task(self._look_at_zones())
        except* PPaaSError as errors:
            raise errors.exceptions[0] from None

    async def _tick(self) -> None:
        while True:
            await asyncio.sleep(TICK)
            for address, robot in tuple(self.robots.items()):
                self._faults.call(f"AGV {address.agv}", robot.tick)

    async def _look_at_zones(self) -> None:
        while True:
            await self._zones.look({robot.map for robot in self.robots.values() if robot.map}, monotonic())
            for address, robot in tuple(self.robots.items()):
                zones = self._zones.in_force(robot.map, epoch())
                if zones is not None:
                    self._faults.call(f"AGV {address.agv}", robot.use_zones, zones)
            await asyncio.sleep(TICK)

    def receive(self, topic: str, payload: bytes, retained: bool) -> None:
        """Take a message of the broker; one that is not valid is logged, and its AGV is not known any more."""
        address: AgvAddress | None = None
        name = ""
        try:
            address, name = parse_topic(topic)
            robot = self.robots.get(address) or self._found(address)
            if robot is not None:
                message = decode(name, payload, version_of(address.major))
                error = self._faults.deliver(f"AGV {address.agv}", robot.take, name, *message, retained=retained)
                if error is not None:
                    raise error
        except PPaaSError as error:
            self._refuse(address, name, error)

    def _found(self, address: AgvAddress) -> AgvRobot | None:
        """Return the robot of an AGV that was not known yet; None for one that is not taken."""
        if not self._options.takes(address) or address in self._ignored:
            return None
        if len(self.robots) >= MAX_AGVS or self._group is None:
            self._ignored = {*tuple(self._ignored)[:MAX_AGVS], address}
            logger.error("AGV %s is left out: there are %d", address.agv, MAX_AGVS)
            return None
        agv = AgvSide(address, self.mqtt.outbox)
        found = AgvRobot(agv, self._url, self._token, registry=self._registry, options=self._options)
        self.robots[address] = found
        self._group.create_task(found.run())
        logger.info("found AGV %s (%s)", agv.name, address.major)
        return found

    def _refuse(self, address: AgvAddress | None, name: str, error: PPaaSError) -> None:
        if address is None or address not in self.robots:
            logger.debug("left out a message: %s", error)
        else:
            self.robots[address].refuse(name, error)

    def _broker_lost(self) -> None:
        for address, robot in self.robots.items():
            self._faults.call(f"AGV {address.agv}", robot.broker_lost)


def filters(interface: str) -> list[str]:
    """Return the filters of the topics of all AGVs, of both major versions."""
    return [f"{interface or usual}/{major}/+/+/{topic}" for major, usual in MAJORS.items() for topic in topics.FROM_AGV]
