"""Buildings of Open-RMF: all floors at once, with grids, zones and the record that joins them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from ppaas.buildings.building import building_of, json_of
from ppaas.buildings.checks import in_building
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.errors import InvalidInput
from ppaas.imports.buildings.rmf_building import ImportedBuilding, drawings_of, import_building
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.zones.zone import Dock, Station
from tests.support.graphs import NO_EFFECT, REFUSED, TRANSLATED, texts
from tests.support.rmf import LIFT, building, floor


def imported(content: bytes | None = None, **options: Any) -> tuple[ImportedBuilding, Any]:
    return import_building(content or building(), "inn.building.yaml", "inn", **options)


def layout(found: ImportedBuilding) -> BuildingLayout:
    return layout_of(found.building, {level: one.zones for level, one in found.maps.items()})


def value_at(grid: GridMap, x: float, y: float) -> int:
    cell = grid.info.cell_of(x, y)
    assert cell is not None
    return int(grid.data[cell])


def apart(found: ImportedBuilding) -> list[str]:
    """Return stations and places of lifts that a robot with a radius of 0.3 m does not reach from the others."""
    landings = [each for places in layout(found).landings.values() for each in places]
    left = []
    for level, one in found.maps.items():
        clear = ndimage.distance_transform_edt(one.grid.data == FREE) * one.grid.info.resolution > 0.3
        areas, _ = ndimage.label(clear)
        points = [(zone.name, *zone.geometry.coordinates[:2]) for zone in one.zones.stations]
        for each in landings:
            if each.floor == level:
                points += [(f"{each.lift} {name}", *at[:2]) for name, at in (("car", each.car), ("wait", each.wait))]
        cells = {name: one.grid.info.cell_of(x, y) for name, x, y in points}
        found_in = {name: int(areas[cell]) if cell else 0 for name, cell in cells.items()}
        first = next(iter(found_in.values()), 0)
        left += [f"{level}: {name}" for name, area in found_in.items() if area == 0 or area != first]
    return left


def test_each_floor_has_a_map_a_height_and_an_anchor() -> None:
    found, report = imported()
    first, second = found.building.floors
    assert (first.name, first.map, first.elevation, first.anchor) == ("L1", "inn-L1", 0.0, (0.0, 0.0, 0.0))
    assert (second.name, second.map, second.elevation) == ("L2", "inn-L2", 4.0)
    assert second.anchor == pytest.approx((-1.5, 0.5, 0.0))
    assert [lift.lift for lift in found.building.lifts] == ["north"]
    assert found.warnings == ()
    assert apart(found) == []
    assert texts(report, REFUSED) == {}
    assert "0.000 m apart at most" in texts(report, TRANSLATED)["levels.L2.fiducials"]


def test_a_lift_stops_at_one_place_of_the_building() -> None:
    found, _ = imported()
    first, second = layout(found).landings["north"]
    assert first.car[:2] == pytest.approx((1.0, -6.0))
    assert second.car[:2] == pytest.approx((2.5, -6.5))
    assert in_building(found.building, "L2", second.car)[:2] == pytest.approx((1.0, -6.0))


@pytest.mark.parametrize(("level", "dx", "dy"), [("L1", 0.0, 0.0), ("L2", 1.5, -0.5)])
def test_walls_are_occupied_doors_open_and_cars_free_with_walls_around(level: str, dx: float, dy: float) -> None:
    found, _ = imported()
    grid = found.maps[level].grid
    assert value_at(grid, dx + 6.0, dy - 1.0) == OCCUPIED  # the inner wall
    assert value_at(grid, dx + 6.0, dy - 3.5) == FREE  # its door
    assert value_at(grid, dx + 9.0, dy - 5.0) == FREE
    assert value_at(grid, dx - 0.5, dy + 0.5) == UNKNOWN  # outside
    assert value_at(grid, dx + 1.0, dy - 6.0) == FREE  # in the car
    assert value_at(grid, dx + 1.0, dy - 5.15) == FREE  # its door
    assert value_at(grid, dx + 1.0, dy - 6.87) == OCCUPIED  # its back
    assert value_at(grid, dx + 1.87, dy - 6.0) == OCCUPIED  # its side


def test_zones_of_floors_have_lanes_stations_and_docks() -> None:
    found, _ = imported()
    for level, x in (("L1", 11.0), ("L2", 12.5)):
        zones = found.maps[level].zones
        assert {zone.rule.name: zone.rule.uses for zone in zones.stations if isinstance(zone.rule, Station)} == {
            "car": [], "lobby": [], "office": ["park"], "charger": ["charge"],
        }  # fmt: skip
        [dock] = [zone for zone in zones.zones if isinstance(zone.rule, Dock)]
        assert (dock.name, dock.rule.yaw) == ("charger dock", 0.0)
        assert dock.geometry.coordinates[0] == pytest.approx(x)
        assert len(zones.lanes) == 2


def test_a_floor_that_is_turned_has_an_anchor_that_turns_it() -> None:
    turned = [[150.0 - y, x, name] for x, y, name in floor()["fiducials"]]
    found, report = imported(building(levels={"L1": floor(), "L2": floor(fiducials=turned)}, lifts={}))
    assert abs(found.building.floors[1].anchor[2]) == pytest.approx(np.pi / 2, abs=1e-6)
    for (px, py, _), (rx, ry, _) in zip(turned, floor()["fiducials"], strict=True):
        place = in_building(found.building, "L2", (px * 0.05, -py * 0.05, 0.0))
        assert place[:2] == pytest.approx((rx * 0.05, -ry * 0.05), abs=1e-6)
    assert texts(report, REFUSED) == {}


def test_fiducials_that_do_not_agree_are_named_with_the_residual() -> None:
    wrong = [*floor(dx=30.0, dy=10.0)["fiducials"][:2], [150.0, 260.0, "C"]]
    _, report = imported(building(levels={"L1": floor(), "L2": floor(dx=30.0, dy=10.0, fiducials=wrong)}))
    [text] = [text for part, text in texts(report, REFUSED).items() if part.startswith("levels.L2.fiducials ")]
    assert text.startswith("fiducials of L2 and L1 do not agree: this one is ")
    assert text.endswith("where the fit of all 3 puts it; move it in one of the drawings")


def test_a_lift_on_one_floor_and_floors_that_nothing_joins_are_warned_of() -> None:
    lonely = LIFT | {"level_doors": {"L1": ["front"]}}
    found, _ = imported(building(lifts={"north": lonely}))
    assert found.building.lifts == ()
    assert found.warnings == (
        "lift 'north' stops on one floor only: robots do not take it",
        "floor 'L2' cannot be reached from 'L1': no lift and no way leads there",
    )


def test_the_grid_is_made_of_the_drawing_where_there_is_one() -> None:
    content = building(levels={"L1": floor(drawing={"filename": "L1.png"}), "L2": floor(dx=30.0, dy=10.0)})
    assert drawings_of(content, "inn") == {"L1": "L1.png"}
    plan = GridMap(np.where(np.indices((160, 240)).min(axis=0) < 4, 100, 0).astype(np.int8), GridInfo(0.05, 240, 160))
    found, report = imported(content, drawings={"L1": save_map(plan, "L1.pgm")[1]})
    grid = found.maps["L1"].grid
    assert (grid.info.origin.x, grid.info.origin.y) == pytest.approx((0.0, -8.0))
    assert value_at(grid, 6.0, -7.95) == OCCUPIED  # the dark lowest rows
    assert value_at(grid, 6.0, -1.0) == FREE  # a wall that is not drawn
    assert value_at(grid, 1.0, -6.0) == FREE
    damaged, report = imported(content, drawings={"L1": b"no picture"})
    assert texts(report, REFUSED)["levels.L1.drawing"].endswith("; the grid is made of walls")
    assert value_at(damaged.maps["L1"].grid, 6.0, -1.0) == OCCUPIED
    missing, report = imported(content)
    text = texts(report, NO_EFFECT)["levels.L1.drawing"]
    assert text == "there is no file 'L1.png': the grid is made of walls"
    assert value_at(missing.maps["L1"].grid, 6.0, -1.0) == OCCUPIED


def test_floors_without_anything_are_left_out_and_names_become_ids() -> None:
    found, report = imported(building(levels={"Floor 1": floor(), "Floor/1": floor(), "roof": {}}, lifts={}))
    assert [each.map for each in found.building.floors] == ["inn-Floor-1", "inn-Floor-1-2"]
    assert [each.name for each in found.building.floors] == list(found.maps) == ["Floor 1", "Floor-1"]
    assert texts(report, REFUSED)["levels.roof"] == "it has neither walls nor lanes nor a drawing, so it is no floor"
    with pytest.raises(InvalidInput, match="has no floor with walls, lanes or a drawing"):
        imported(building(levels={"roof": {}}, lifts={}))


def test_names_that_a_building_does_not_take_are_changed() -> None:
    levels = {"L/1": floor(), "x" * 70: floor(), "x" * 80: floor()}
    stops = {"level_doors": {"L/1": ["front"], "x" * 70: ["front"]}, "reference_floor_name": "L/1"}
    found, _ = imported(building(levels=levels, lifts={"a/b": LIFT | stops, "a-b": LIFT | stops}))
    assert building_of(json_of(found.building)) == found.building
    assert [each.name for each in found.building.floors] == ["L-1", "x" * 64, "x" * 62 + "-2"]
    assert [lift.lift for lift in found.building.lifts] == ["a-b", "a-b-2"]
    assert layout(found).landings.keys() == {"a-b", "a-b-2"}


@pytest.mark.parametrize(
    "junk", [None, 3.7, "x", {"a": 1}, [[99, 98, {}]], [{"vertices": [0, 99]}], [[1e308, 1e308, 0]]]
)
@pytest.mark.parametrize("name", ["walls", "floors", "holes", "drawing", "elevation", "fiducials"])
def test_any_values_of_a_floor_are_read(name: str, junk: object) -> None:
    found, _ = imported(building(levels={"L1": floor(), "L2": floor(**{name: junk})}, lifts={}))
    assert len(found.building.floors) == 2


def test_the_hotel_has_two_lifts_on_three_floors(data: Path) -> None:
    content = (data / "buildings" / "hotel.building.yaml").read_bytes()
    found, report = imported(content, options=GraphOptions(graph=0))
    assert [(each.name, each.elevation) for each in found.building.floors] == [("L1", 0.0), ("L2", 8.0), ("L3", 16.0)]
    assert {lift: len(places) for lift, places in layout(found).landings.items()} == {"Lift1": 3, "Lift2": 3}
    assert (found.warnings, texts(report, REFUSED)) == ((), {})
    assert apart(found) == []


@pytest.mark.parametrize("name", ["airport_terminal", "campus", "door_madness", "office"])
def test_real_buildings_are_imported(data: Path, name: str) -> None:
    content = (data / "buildings" / f"{name}.building.yaml").read_bytes()
    found, report = imported(content, resolution=0.2)
    assert (len(found.building.floors), found.warnings, texts(report, REFUSED)) == (1, (), {})
    assert apart(found) == []
