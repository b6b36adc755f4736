"""Fleet of a bridge without a broker and a cloud, and messages of its AGVs, for tests."""

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode, encode
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.topics import AgvAddress, Version
from robots.bridges.agv.agv_robot import AgvRobot
from robots.bridges.agv.agv_side import AgvSide
from robots.bridges.agv.fleet import Fleet
from robots.bridges.agv.options import FleetOptions
from robots.bridges.vda5050.broker import Broker
from tests.support.vda5050.simple_agv import SimpleAgv

NOWHERE = "http://127.0.0.1:9"


class FleetWithAgv:
    """Fleet with one AGV, whose messages are given to it, and that gets what the fleet sends.

    Attributes
    ----------
    fleet : Fleet
    robot : AgvRobot
    agv : SimpleAgv
    address : AgvAddress
    clock : float
        Time by which the AGV's clock is ahead [s].
    """

    def __init__(self, version: Version = Version.V2_1, **options: object) -> None:
        self.version = version
        self.fleet = Fleet(NOWHERE, "token", Broker("127.0.0.1", 9), FleetOptions(**options))  # type: ignore[arg-type]
        self.address = AgvAddress.of(version, "acme", "fork-7")
        self.agv = SimpleAgv(Pose2D(0.0, 0.0))
        self.clock = 0.0
        self.header_ids(0)
        self.robot = AgvRobot(
            AgvSide(self.address, self.fleet.mqtt.outbox), NOWHERE, "token",
            registry=self.fleet._registry, options=self.fleet._options,
        )  # fmt: skip
        self.fleet.robots[self.address] = self.robot

    def header_ids(self, first: int) -> None:
        """Count the header ids of all topics from a number on, as an AGV does from 0 that was restarted."""
        self._headers = HeaderCounter(self.version, self.address)
        self._first = first

    def payload(self, topic: str, body: Fields) -> bytes:
        """Return a message of the AGV."""
        header = self._headers.next(topic, epoch() + self.clock)
        header.header_id += self._first
        return encode(topic, header, body, self.version)

    def say(self, topic: str, body: Fields) -> bytes:
        """Let the AGV publish a message; return its payload."""
        payload = self.payload(topic, body)
        self.fleet.receive(self.address.topic(topic), payload, False)
        return payload

    async def obey(self) -> None:
        """Give the AGV what the fleet has sent."""
        while len(self.fleet.mqtt.outbox):
            message = await self.fleet.mqtt.outbox.next()
            topic = message.topic.rpartition("/")[2]
            body = decode(topic, message.payload, self.version)[1]
            if topic == topics.ORDER:
                self.agv.take_order(body)
            elif topic == topics.ZONE_SET:
                self.agv.take_zones(body)
            else:
                self.agv.take_actions(body)
