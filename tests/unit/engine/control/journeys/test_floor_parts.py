"""What the clone of a robot is asked that leaves a lift: parts of maps around the car, and where it is on each."""

import pytest
from msgspec.structs import replace

from engine.control.journeys import floor_parts
from engine.control.journeys.floor_parts import FloorParts, floor_request
from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.buildings.riding.floor_maps import grid_of
from ppaas.errors import NotFound
from ppaas.geometry import Pose2D
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from storage.memory.maps import MemoryMapStore
from tests.support.storage import records


def layout(count: int = 3) -> BuildingLayout:
    """Return a building whose lift is a metre further on each map."""
    floors = tuple(Floor(name=f"L{n}", map=f"map-{n}", elevation=4.0 * n, anchor=(-n, 0, 0)) for n in range(count))
    zones = {}
    for number, floor in enumerate(floors):
        ring = [[number + x, y] for x, y in ((1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0), (1.0, 1.0))]
        door = LineString([[number + 1.5, 3.1], [number + 2.5, 3.1]])
        zones[floor.name] = ZoneSet(
            [Zone(Polygon([ring]), LiftCar(name="car", lift="north")), Zone(door, Door(name="door", lift="north"))]
        )
    return layout_of(Building(floors=floors, lifts=(LiftSettings(lift="north", device="sim:"),)), zones)


@pytest.fixture
def maps() -> MemoryMapStore:
    made = MemoryMapStore()
    for number in range(3):
        records.put_map(made, records.house(f"map-{number}"))
    return made


LEG = JourneyLeg(kind="lift", floor="L0", to_floor="L1", start=(0.0, 0.0, 0.0), goal=(0.0, 0.0, 0.0), name="north")
JOURNEY = Journey(
    id="j", user="ann", robot="tb1", building="hotel", floor="L1", goal=(0.0, 0.0, 0.0), on="L1", legs=(LEG,),
    phase="alighting", out="L1", pressure=99_000.0, pressure_at=50.0,
)  # fmt: skip


def test_the_parts_of_all_floors_are_sent_with_where_the_robot_is_on_each(maps: MemoryMapStore) -> None:
    building = layout()
    parts = FloorParts(maps).of(JOURNEY, building)
    request = floor_request(JOURNEY, building, parts, (3.0, 2.5, 1.5), 80.0)
    assert (request.origin, request.destination, request.named) == ("L0", "L1", "L1")
    assert (request.pressure, request.seconds) == (99_000.0, 30.0)
    assert request.clear == pytest.approx(1.4 - 0.5)
    outside = floor_request(replace(JOURNEY, phase="looking"), building, parts, None, 80.0)
    assert (outside.clear, floor_request(JOURNEY, building, parts, None, 80.0).clear) == (0.0, pytest.approx(1.4))
    changes = {part.floor: part.change.planar() for part in request.floors}
    assert changes["L0"] == pytest.approx(Pose2D(-1.0, 0.0, 0.0)) and changes["L1"] == pytest.approx(Pose2D(0, 0, 0))
    assert changes["L2"] == pytest.approx(Pose2D(1.0, 0.0, 0.0))
    assert {part.elevation for part in request.floors} == {0.0, 4.0, 8.0}
    assert grid_of(request.floors[0]).data.shape == (3, 4), "the whole map, for it is small"


def test_parts_are_kept_until_the_map_has_another_version(maps: MemoryMapStore) -> None:
    building, parts = layout(), FloorParts(maps)
    first = parts.of(JOURNEY, building)
    assert parts.of(JOURNEY, building)["L1"] is first["L1"]
    assert parts.of(JOURNEY, layout(2))["L1"] is first["L1"]


def test_floors_without_a_map_are_left_out_but_not_those_of_the_ride(maps: MemoryMapStore) -> None:
    building = layout(4)
    parts = FloorParts(maps).of(JOURNEY, building)
    assert sorted(parts) == ["L0", "L1", "L2"]
    with pytest.raises(NotFound, match="map around the lift of floor"):
        floor_request(JOURNEY, building, {"L1": parts["L1"]}, None, 80.0)


def test_in_a_high_building_the_floors_of_the_ride_and_those_next_to_it_are_compared(
    maps: MemoryMapStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(floor_parts, "MOST_FLOORS", 2)
    assert sorted(FloorParts(maps).of(JOURNEY, layout())) == ["L0", "L1"]
