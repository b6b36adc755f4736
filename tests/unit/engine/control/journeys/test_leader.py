"""Leader of journeys: which robots it sends where, and what it refuses."""

import asyncio
import math
from collections.abc import AsyncIterator
from typing import Any

import msgspec
import numpy as np
import pytest

from engine.control.journeys.kept import keep_journeys
from engine.control.journeys.leader import JourneyLeader, view_of
from engine.control.journeys.site import JourneySite
from engine.control.planning.building_requests import BuildingScene, BuildingSpot
from engine.links.presence import RobotPresence
from engine.master.places import PlaceRequest, robot_key
from engine.processes.background import cancel_all
from engine.specs.containers import MapVersion
from ppaas.buildings.building import Building, Floor
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.errors import Conflict, InvalidBuilding, InvalidInput, NotFound, Unavailable
from ppaas.geometry import Pose2D
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.engine.specs import robot_config
from tests.support.storage import records
from tests.support.waiting import until

KEY = robot_key("ann", "tb1")
POSE = Pose2D(1.0, 2.0, 0.5)
HOTEL = Building(floors=(Floor(name="L1", map="house"), Floor(name="L2", map="loft", elevation=3.0)))


class Driver:
    """Places of robots that have no containers."""

    def __init__(self) -> None:
        self.presence = RobotPresence(lambda _key: None)
        self.map = "house"
        self.containers = self

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
    await cancel_all([known.running for known in made._sites.values()])


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


async def test_a_goal_of_a_task_is_sent_once_and_stored_ones_go_on_whoever_asks_first(
    leader: JourneyLeader, store: MemoryStore
) -> None:
    first = await leader.lead("ann", "tb1", "L2", POSE, goal_id="task-t-0-0")
    assert await leader.lead("ann", "tb1", "L2", POSE, goal_id="task-t-0-0") == first
    assert [journey.id for journey in leader.of_robot("ann", "tb1")] == ["task-t-0-0"]
    await leader.cancel_journey("ann", "tb1", "task-t-0-0")
    await until(lambda: all(known.site.is_idle for known in leader._sites.values()))
    await cancel_all([known.running for known in leader._sites.values()])
    leader._sites.clear()
    leader._known.clear()
    stored = msgspec.structs.replace(first, sent=3)
    keep_journeys(store, ("bob", "hotel"), [stored], [], 1.0)
    assert (await leader.lead("ann", "tb1", "L2", POSE, goal_id="task-t-0-0")).sent == stored.sent


async def test_times_in_a_building_are_of_those_lifts_that_serve(
    leader: JourneyLeader, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes: list[BuildingScene] = []

    async def costs(user: str, scene: BuildingScene, *ends: Any) -> Any:
        scenes.append(scene)
        return np.array([[4.0, math.inf]])

    monkeypatch.setattr(leader._planning, "costs", costs)
    spots = [BuildingSpot("L1", 1.0, 2.0)]
    assert await leader.times("ann", "house", spots, [*spots, BuildingSpot("L2", 1.0, 2.0)]) == [[4.0, None]]
    monkeypatch.setattr(JourneySite, "out_of_order", lambda _self: frozenset({"north"}))
    await leader.times("ann", "house", spots, spots)
    assert [scene.traveller.avoid for scene in scenes] == [frozenset(), {"north"}]
    with pytest.raises(InvalidInput, match="no floor of a building"):
        await leader.times("ann", "yard", spots, spots)


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
    await until(lambda: all(known.site.is_idle for known in leader._sites.values()))
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
