"""Zones of the cloud's maps, and the AGVs that are told them."""

import json
from collections.abc import Sequence
from typing import Any

import pytest
from msgspec.structs import replace

from ppaas.errors import Unavailable
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.states import Connection
from ppaas.wire.vda5050.topics import Version
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import Zone
from robots.bridges.agv.zones import PERIOD, ZoneReader
from robots.client.rest import RestClient
from tests.support.vda5050.fleet import FleetWithAgv
from tests.support.vda5050.messages import FACTSHEET
from tests.support.vda5050.schemas import problems

ONLINE = Connection(connection_state="ONLINE")
MONDAY = 1_790_000_000.0  # 13:33 UTC


def geojson(*rules: dict[str, Any]) -> str:
    area = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]}
    made = [{"type": "Feature", "geometry": area, "properties": rule} for rule in rules]
    return json.dumps({"type": "FeatureCollection", "features": made, "in_force": [], "time_zone": "UTC"})


def zones(*rules: dict[str, Any]) -> Sequence[Zone]:
    return zones_of(geojson(*rules)).zones


def sheet(*supported: str) -> Factsheet:
    assert FACTSHEET.type_specification is not None
    return replace(FACTSHEET, type_specification=replace(FACTSHEET.type_specification, supported_zones=[*supported]))


DOCK, RAMP = {"name": "dock", "kind": "keep_out"}, {"name": "ramp", "kind": "speed_limit", "percent": 50}


class Cloud(RestClient):
    """Cloud that has zones of the map office, and counts the questions."""

    def __init__(self, text: str) -> None:
        super().__init__("http://127.0.0.1:9", "token")
        self.text: str | None = text
        self.asked: list[str] = []

    async def fetch(self, path: str) -> bytes:
        """Return the zones."""
        self.asked.append(path)
        if self.text is None:
            raise Unavailable("the cloud is away")
        return self.text.encode()


async def test_zones_are_read_from_time_to_time_and_stay_while_the_cloud_is_away(caplog) -> None:
    cloud = Cloud(geojson(DOCK))
    reader = ZoneReader(cloud)
    assert reader.in_force("office", MONDAY) is None
    await reader.look(["office"], 0.0)
    found = reader.in_force("office", MONDAY)
    assert found is not None and [zone.name for zone in found] == ["dock"]
    await reader.look(["office"], PERIOD - 1.0)
    assert cloud.asked == ["/v1/maps/office/zones"]
    cloud.text = None
    for number in (1, 2):
        await reader.look(["office"], number * PERIOD)
    assert reader.in_force("office", MONDAY) is found
    assert caplog.text.count("the zones of map office cannot be read: the cloud is away") == 1
    cloud.text = geojson(DOCK, RAMP)
    await reader.look(["office"], 3 * PERIOD)
    assert len(reader.in_force("office", MONDAY) or ()) == 2
    await reader.look([], 4 * PERIOD)
    assert reader.in_force("office", MONDAY) is None


async def test_zones_in_force_change_with_time_alone() -> None:
    reader = ZoneReader(Cloud(geojson(DOCK, {**RAMP, "times": [{"from": "14:00", "to": "15:00"}]})))
    await reader.look(["office"], 0.0)
    first = reader.in_force("office", MONDAY)
    assert reader.in_force("office", MONDAY + 60.0) is first
    later = reader.in_force("office", MONDAY + 1800.0)
    assert later is not None and [zone.name for zone in later] == ["dock", "ramp"]


async def told(tested: FleetWithAgv, states: int = 5) -> list[dict[str, Any]]:
    """Let the AGV say its state some times; return the sets of zones that it was sent."""
    sent: list[dict[str, Any]] = []
    for _ in range(states):
        tested.say(topics.STATE, tested.agv.state())
        outbox = tested.fleet.mqtt.outbox
        for _ in range(len(outbox)):
            message = await outbox.next()
            topic = message.topic.rpartition("/")[2]
            body = decode(topic, message.payload, tested.version)[1]
            if topic == topics.ZONE_SET:
                assert problems(tested.version, topic, message.payload) == []
                sent.append(json.loads(message.payload)["zoneSet"])
                tested.agv.take_zones(body)
            else:
                tested.agv.take_actions(body)
    return sent


def connected(version: Version = Version.V3_0, factsheet: Factsheet | None = None) -> FleetWithAgv:
    tested = FleetWithAgv(version, maps={"hall": "office"})
    tested.say(topics.CONNECTION, ONLINE)
    tested.say(topics.STATE, tested.agv.state())
    if factsheet is not None:
        tested.say(topics.FACTSHEET, factsheet)
    tested.robot._map = "office"
    return tested


async def test_an_agv_gets_the_zones_that_it_supports_and_uses_them(caplog) -> None:
    tested = connected(factsheet=sheet("BLOCKED", "SPEED_LIMIT", "RELEASE"))
    lane = {"name": "lane", "kind": "one_way", "direction": 0.0}
    few, quiet = {"name": "lift", "kind": "capacity", "robots": 1}, {"name": "door", "kind": "no_stop"}
    given = zones(DOCK, RAMP, lane, few, quiet)
    tested.robot.use_zones(given)
    tested.robot.use_zones(given)
    (sent,) = await told(tested)
    assert sent["mapId"] == "hall", "as the AGV names it"
    assert FACTSHEET.physical_parameters is not None
    speed = 0.5 * FACTSHEET.physical_parameters.maximum_speed
    assert [(zone["zoneId"], zone["zoneType"], zone.get("maximumSpeed")) for zone in sent["zones"]] == [
        ("dock", "BLOCKED", None),
        ("ramp", "SPEED_LIMIT", pytest.approx(speed)),
    ]
    assert tested.agv.enabled_zones == sent["zoneSetId"]
    for text in ("zone 'door' is of the kind no_stop", "support DIRECTED (zone 'lane')", "zone 'lift' is RELEASE"):
        assert caplog.text.count(text) == 1


async def test_other_zones_replace_those_before() -> None:
    tested = connected(factsheet=sheet("BLOCKED"))
    tested.robot.use_zones(zones(DOCK))
    (first,) = await told(tested)
    tested.robot.use_zones(zones({**DOCK, "name": "gate"}))
    (second,) = await told(tested)
    assert list(tested.agv.zone_sets) == [second["zoneSetId"]] != [first["zoneSetId"]]
    tested.robot.use_zones([])
    (none,) = await told(tested)
    assert none["zones"] == [] and tested.agv.enabled_zones == none["zoneSetId"]


@pytest.mark.parametrize(
    ("version", "factsheet", "text"),
    [(Version.V2_1, sheet("BLOCKED"), "it speaks VDA 5050 2.1"), (Version.V3_0, None, "it sends no factsheet")],
)
async def test_agvs_without_zones_are_named_once(version: Version, factsheet: Any, text: str, caplog) -> None:
    tested = connected(version, factsheet)
    for _ in range(3):
        tested.robot.use_zones(zones(DOCK))
    assert await told(tested) == []
    assert caplog.text.count(text) == 1


async def test_an_agv_on_another_map_gets_no_zones() -> None:
    tested = connected(factsheet=sheet("BLOCKED"))
    tested.robot._map = "yard"
    tested.robot.use_zones(zones(DOCK))
    assert await told(tested) == []
