"""Topics of an AGV at a broker, without the broker."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import NotFound
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.agv.agv import Abilities, Agv
from ppaas.wire.vda5050.agv.commands import RobotPose
from ppaas.wire.vda5050.agv.report import Telemetry
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.orders import InstantActions
from ppaas.wire.vda5050.states import PowerSupply
from ppaas.wire.vda5050.topics import AgvAddress, Version
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.factsheet import factsheet_of
from robots.bridges.vda5050.fleet_side import FleetSide
from robots.bridges.vda5050.mqtt_link import Exchange, Outbox, Outgoing
from tests.support.vda5050.damaged import damaged
from tests.support.vda5050.orders import MAP, action, order
from tests.support.vda5050.schemas import problems


class Side:
    """An AGV with the topics of a version."""

    def __init__(self, version: Version) -> None:
        self.version, self.address = version, AgvAddress.of(version, "ppaas", "tb1")
        self.agv = Agv(version, Abilities(MAP, frozenset({"beep"}), ("BLOCKED",)))
        self.agv.link(connected=True)
        self.agv.robot_at(RobotPose(0.0, 0.0, 0.0))
        telemetry = Telemetry(PowerSupply(state_of_charge=50.0, charging=False))
        options = AgvOptions(version, state_interval=0.2)
        sheet = factsheet_of({"model": "turtlebot2"}, options)
        self.side = FleetSide(self.agv, telemetry, sheet, map_id=MAP, serial="tb1", options=options)
        self.outbox = Outbox()
        self.side.use(self.outbox)
        self.exchange: Exchange = self.side.exchange(lambda: None)
        self._headers = HeaderCounter(version, self.address)

    def receive(self, name: str, payload: bytes, *, retained: bool = False) -> None:
        self.exchange.received(self.address.topic(name), payload, retained)

    def payload(self, name: str, body: Fields) -> bytes:
        return encode(name, self._headers.next(name, 0.0), body, self.version)

    async def sent(self) -> list[Outgoing]:
        return [await self.outbox.next() for _ in range(len(self.outbox))]


def told(message: Outgoing) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(message.payload)
    return found


@pytest.mark.parametrize("version", Version)
async def test_an_agv_that_connects_tells_who_it_is_and_leaves_its_will(version: Version) -> None:
    side = Side(version)
    will, farewell = side.exchange.will(), side.exchange.farewell()
    side.exchange.connected()
    side.side.publish_due()
    online, sheet, state, shown = await side.sent()
    assert [told(one)["connectionState"] for one in (online, farewell) if one is not None] == ["ONLINE", "OFFLINE"]
    assert will is not None and told(will)["connectionState"] in ("CONNECTIONBROKEN", "CONNECTION_BROKEN")
    assert {(one.qos, one.retain) for one in (online, will)} == {(1, True)}
    names = [one.topic.rpartition("/")[2] for one in (online, sheet, state, shown)]
    assert names == ["connection", "factsheet", "state", "visualization"]
    for name, one in zip(names, (online, sheet, state, shown), strict=True):
        assert problems(version, name, one.payload) == []
    assert [told(one)["headerId"] for one in (will, farewell, online) if one is not None] == [0, 1, 2]


async def test_messages_reach_the_agv() -> None:
    side = Side(Version.V2_1)
    side.receive(topics.ORDER, side.payload(topics.ORDER, order(0, 1)))
    assert side.agv.orders.order_id == "o1"
    cancel = InstantActions(actions=[action("cancelOrder", "i")])
    side.receive(topics.INSTANT_ACTIONS, side.payload(topics.INSTANT_ACTIONS, cancel))
    assert side.agv.orders.cancelled


async def test_retained_orders_and_other_topics_are_ignored() -> None:
    side = Side(Version.V2_1)
    payload = side.payload(topics.ORDER, order(0, 1))
    side.receive(topics.ORDER, payload, retained=True)
    side.exchange.received("uagv/v2/ppaas/tb2/order", payload, False)
    side.receive(topics.ZONE_SET, payload)
    assert side.agv.orders.order_id == "" and side.agv.errors == []


async def test_messages_that_cannot_be_read_are_reported() -> None:
    side = Side(Version.V2_1)
    side.receive(topics.ORDER, b'{"orderId": 7}')
    (error,) = side.agv.errors
    assert error.error_type == "VALIDATION_FAILURE" and "field `headerId`" in str(error.error_description)


@given(st.lists(damaged(), max_size=3))
async def test_damaged_messages_leave_the_state_valid(messages: list[tuple[Version, str, bytes]]) -> None:
    version = messages[0][0] if messages else Version.V2_0
    side = Side(version)
    for _, topic, payload in messages:
        side.receive(topic, payload)
        side.agv.take_commands()
    side.side.publish_due()
    for one in await side.sent():
        assert problems(version, one.topic.rpartition("/")[2], one.payload) == []


@pytest.mark.parametrize("version", Version)
@pytest.mark.parametrize("model", ["turtlebot2", "turtlebot3_burger"])
def test_factsheets_satisfy_the_published_schemas(version: Version, model: str) -> None:
    options = AgvOptions(version, services={"beep": "/beep"}, zones=True)
    sheet = factsheet_of({"model": model, "description": "a robot"}, options)
    headers = HeaderCounter(version, AgvAddress.of(version, "ppaas", "tb1"))
    payload = encode(topics.FACTSHEET, headers.next(topics.FACTSHEET, 0.0), sheet, version)
    assert problems(version, topics.FACTSHEET, payload) == []


def test_a_factsheet_tells_the_body_and_the_actions_of_its_version() -> None:
    old, new = (
        factsheet_of({"model": "turtlebot3_burger"}, AgvOptions(version, services={"beep": "/beep"}))
        for version in (Version.V2_1, Version.V3_0)
    )
    body = new.physical_parameters
    assert (body.maximum_speed, body.maximum_height) == (0.22, 0.192)
    assert body.width == pytest.approx(0.21) and body.length == pytest.approx(0.21)
    names = [{one.action_type for one in sheet.protocol_features.mobile_robot_actions} for sheet in (old, new)]
    assert names[0] ^ names[1] == {
        "initPosition", "initializePosition", "clearInstantActions", "enableZoneSet", "deleteZoneSet",
    }  # fmt: skip
    assert "beep" in names[0] & names[1]
    assert new.type_specification.supported_zones == []


def test_an_unknown_model_is_refused() -> None:
    with pytest.raises(NotFound, match="robot model"):
        factsheet_of({"model": "rover"}, AgvOptions())
