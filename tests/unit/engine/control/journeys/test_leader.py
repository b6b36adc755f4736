"""Leader of journeys: which robots it sends where, and what it refuses."""

import asyncio
import math
from collections.abc import AsyncIterator
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from msgspec.structs import replace

from engine.control.counts import ControlCounts
from engine.control.fleet_events import FleetEvents
from engine.control.journeys.kept import keep_journeys
from engine.control.journeys.leader import JourneyLeader, view_of
from engine.control.planning.building_requests import BuildingScene
from engine.devices.hosts import DeviceHosts
from engine.links.presence import RobotPresence
from engine.master.places import PlaceRequest, robot_key
from engine.specs.containers import MapVersion
from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import layout_of
from ppaas.clock import epoch
from ppaas.errors import Conflict, InvalidBuilding, InvalidInput, NotFound, Unavailable
from ppaas.geometry import Pose2D
from ppaas.zones.reading import geojson_of
from ppaas.zones.zone import ZoneSet
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.records import RobotRecord
from tests.support.buildings import LiftServer
from tests.support.endpoints.serving import serve
from tests.support.engine.specs import robot_config
from tests.support.storage import records
from tests.support.waiting import until
from tests.unit.engine.control.journeys.test_site import Robot
from tests.unit.engine.control.planning.test_buildings import IndexedPlanning
from tests.unit.ppaas.buildings.planning.random_buildings import lift, two_floors

KEY = robot_key("ann", "tb1")
POSE = Pose2D(1.0, 2.0, 0.5)
HOTEL = Building(floors=(Floor(name="L1", map="house"), Floor(name="L2", map="loft", elevation=3.0)))


class Driver:
    """Places of robots that have no containers."""

    def __init__(self) -> None:
        self.presence = RobotPresence(lambda _key: None)
        self.map = "house"
        self.containers = self
        self.counts, self.events = ControlCounts(), FleetEvents()

    def request_of(self, key: str) -> PlaceRequest | None:
        return PlaceRequest("ann", MapVersion(self.map, "v1"), 1.0, robot_config("tb1")) if key == KEY else None

    def place(self, key: str) -> None:
        return None

    def of_robot(self, key: str) -> None:
        return None


@pytest.fixture
def driver() -> Driver:
    made = Driver()
    made.presence.came(KEY)
    return made


@pytest.fixture
def store() -> MemoryStore:
    made = MemoryStore()
    version = BuildingVersion(number=1, building=HOTEL, author="bob", created=1.0)
    made.put_building(BuildingRecord(user="bob", id="hotel", present=version, readers=("ann",)))
    return made


@pytest.fixture
async def leader(driver: Driver, store: MemoryStore) -> AsyncIterator[JourneyLeader]:
    maps = MemoryMapStore()
    for name in ("house", "loft"):
        records.put_map(maps, records.house(name))
    unused: Any = None
    made = JourneyLeader(driver, unused, store, maps, unused)  # type: ignore[arg-type]
    yield made
    await made._sites.close()


async def test_a_robot_is_sent_in_the_building_that_its_map_is_a_floor_of(leader: JourneyLeader) -> None:
    sent = await leader.send_to_floor("ann", "tb1", "L2", POSE)
    assert (sent.state, sent.pose, sent.ended) == ("active", tuple(POSE), None)
    again = await leader.send_to_floor("ann", "tb1", "L1", POSE)
    assert [(goal.id, goal.state) for goal in await leader.journeys("ann", "tb1")] == [
        (sent.id, "canceled"), (again.id, "active"),
    ]  # fmt: skip
    assert (await leader.cancel_journey("ann", "tb1", again.id)).state == "canceled"
    with pytest.raises(Conflict, match="has ended: canceled"):
        await leader.cancel_journey("ann", "tb1", again.id)
    with pytest.raises(NotFound):
        await leader.cancel_journey("ann", "tb1", "journey-9")
    assert await leader.journeys("ann", "tb2") == []


async def test_a_journey_is_planned_for_what_the_robot_can_do(leader: JourneyLeader, store: MemoryStore) -> None:
    scenes: list[BuildingScene] = []

    async def plan(_user: str, scene: BuildingScene, *_ends: object) -> list[Any]:
        scenes.append(scene)
        return [SimpleNamespace(legs=[])]

    leader._planning = SimpleNamespace(plan=plan)  # type: ignore[assignment]
    store.put_robot(RobotRecord("tb1", "ann", "house", properties={"stairs": True, "arm": "left"}))
    journey = Journey(id="j", user="ann", robot="tb1", building="hotel", floor="L2", goal=tuple(POSE), on="L1")
    record = store.building("bob", "hotel")
    assert await leader._plan(record, layout_of(HOTEL, {}), replace(journey, avoid=("north",)), tuple(POSE)) == []
    traveller = scenes[0].traveller
    assert (traveller.stairs, traveller.labels["arm"], traveller.avoid) == (True, "left", frozenset({"north"}))


async def test_a_building_that_was_changed_is_read_again_once_nobody_travels(
    leader: JourneyLeader, store: MemoryStore
) -> None:
    sent = await leader.send_to_floor("ann", "tb1", "L2", POSE)
    before = store.building("bob", "hotel")
    larger = Building(floors=(*HOTEL.floors, Floor(name="L3", map="roof")))
    store.put_building(
        before.followed_by(BuildingVersion(number=2, building=larger, author="bob", created=2.0)), instead_of=before
    )
    with pytest.raises(InvalidBuilding, match="there is no floor 'L3'"):
        await leader.send_to_floor("ann", "tb1", "L3", POSE)
    await leader.cancel_journey("ann", "tb1", sent.id)
    await until(lambda: all(site.is_idle for site in leader._sites))
    assert (await leader.send_to_floor("ann", "tb1", "L3", POSE)).state == "active"


async def test_what_cannot_be_is_refused(leader: JourneyLeader, driver: Driver, store: MemoryStore) -> None:
    with pytest.raises(Unavailable, match="not connected"):
        await leader.send_to_floor("ann", "tb2", "L2", POSE)
    with pytest.raises(InvalidBuilding, match="there is no floor 'roof'"):
        await leader.send_to_floor("ann", "tb1", "roof", POSE)
    driver.map = "depot"
    with pytest.raises(InvalidInput, match="map 'depot' is no floor of a building of yours"):
        await leader.send_to_floor("ann", "tb1", "L2", POSE)
    driver.map = "house"
    store.remove_building("bob", "hotel")
    version = BuildingVersion(number=1, building=HOTEL, author="bob", created=1.0)
    store.put_building(BuildingRecord(user="bob", id="hotel", present=version))
    with pytest.raises(InvalidInput, match="of a building of yours"):
        await leader.send_to_floor("ann", "tb1", "L2", POSE)


async def test_a_robot_in_a_lift_is_sent_nowhere_else_and_stored_journeys_go_on(
    leader: JourneyLeader, store: MemoryStore
) -> None:
    leg = JourneyLeg(kind="lift", floor="L1", to_floor="L2", start=(0.0, 0.0, 0.0), goal=(0.0, 0.0, 0.0), name="north")
    riding = Journey(
        id="journey-1", user="ann", robot="tb1", building="hotel", floor="L2", goal=(1.0, 2.0, 0.0), on="L1",
        legs=(leg,), phase="inside",
    )  # fmt: skip
    keep_journeys(store, ("bob", "hotel"), [riding], [], 1.0)
    running = asyncio.create_task(leader.run())
    found: list[Any] = []

    async def listed() -> None:
        found[:] = await leader.journeys("ann", "tb1")

    while not found:
        await listed()
        await asyncio.sleep(0.01)
    assert found[0].id == "journey-1"
    with pytest.raises(Conflict, match="is in a lift, on journey 'journey-1'"):
        await leader.send_to_floor("ann", "tb1", "L2", POSE)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


def test_a_journey_that_failed_is_an_aborted_goal() -> None:
    journey = Journey(
        id="journey-1", user="ann", robot="tb1", building="hotel", floor="L2", goal=(1.0, 2.0, 0.0), on="L1",
        state="failed", text="fire", ended=9.0,
    )  # fmt: skip
    view = view_of(journey)
    assert (view.id, view.state, view.text, view.ended) == ("journey-1", "aborted", "fire", 9.0)


async def test_a_journey_takes_the_other_lift_while_one_is_out_of_order(
    driver: Driver, store: MemoryStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    gateway, two = LiftServer(), two_floors(lift("south", 4.0, 2.5))
    gateway.lift.set_mode("fire", epoch())
    maps = MemoryMapStore()
    zones = ZoneSet([*lift("north", 1.0, 1.0), *lift("south", 4.0, 2.5)])
    for name in ("m0", "m1"):
        records.put_map(maps, records.house(name, zones=geojson_of(zones)))
    driver.map = "m0"
    async with serve(gateway) as port:
        url = f"http://127.0.0.1:{port}/lift?floors=L0:1,L1:2&poll=0.1"
        lifts = (LiftSettings(lift="north", device=url), LiftSettings(lift="south", device="sim:"))
        building = msgspec.structs.replace(two.layout.building, lifts=lifts)
        version = BuildingVersion(number=1, building=building, author="ann", created=1.0)
        store.put_building(BuildingRecord(user="ann", id="inn", present=version))
        store.put_robot(RobotRecord("tb1", "ann", "m0"))
        planning, hosts = IndexedPlanning(two.planner()), DeviceHosts(["127.0.0.1"])
        leader = JourneyLeader(driver, None, store, maps, planning, hosts=hosts)  # type: ignore[arg-type]
        monkeypatch.setattr(
            leader, "_rider", lambda journey, ended: Robot(map="m0", pose=(0.5, 0.5, 0.0), reaches=False)
        )
        try:
            assert await leader.lift_waits("ann", "inn") == []
            seen = await leader.building_state("ann", "inn")
            assert [view.fault for view in seen.devices.lifts] == ["lift 'north' is in the mode 'fire'", ""]
            waits = {(wait.lift, wait.floor): wait.seconds for wait in await leader.lift_waits("ann", "inn")}
            assert math.isinf(waits["north", "L0"]) and waits["south", "L0"] < 30.0
            await leader.send_to_floor("ann", "tb1", "L1", Pose2D(0.5, 0.5, 0.0))
            site = leader._sites.get(("ann", "inn"))
            assert site is not None
            await until(lambda: bool(site.journeys[0].legs))
            assert [leg.name for leg in site.journeys[0].legs if leg.kind == "lift"] == ["south"]
        finally:
            await leader._sites.close()


async def test_the_state_of_no_building_is_not_found(leader: JourneyLeader) -> None:
    with pytest.raises(NotFound):
        await leader.building_state("bob", "motel")
