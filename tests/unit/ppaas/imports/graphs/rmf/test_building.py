"""Buildings of Open-RMF: lanes, named vertices and doors of one floor, in metres."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.imports.graphs.reading import import_graph, read_graph
from ppaas.zones.zone import Capacity, Dock, Door, LiftCar, NoStop, SpeedZone
from tests.support.graphs import NO_EFFECT, REFUSED, TRANSLATED, segments_of, texts

VERTICES = [
    [100.0, 200.0, 0.0, ""],
    [300.0, 200.0, 0.0, "ramp", {"is_charger": [4, True], "is_parking_spot": [4, False], "dock_name": [1, "d"]}],
    [300.0, 100.0, 0.0, ""],
    [0.0, 0.0, 0.0, "corner"],
    [200.0, 150.0, 0.0, ""],
    [200.0, 250.0, 0.0, ""],
]
LANES = [
    [
        0,
        1,
        {
            "bidirectional": [4, True],
            "graph_idx": [2, 0],
            "orientation": [1, "forward"],
            "speed_limit": [3, 0.4],
            "mutex": [1, "ramp"],
        },
    ],
    [1, 2, {"bidirectional": [4, False], "graph_idx": [2, 0], "speed_limit": [3, 0]}],
    [2, 0, {"bidirectional": [4, False], "graph_idx": [2, 3]}],
]
FLOOR = {
    "vertices": VERTICES,
    "lanes": LANES,
    "measurements": [[0, 1, {"distance": [3, 10.0]}]],
    "doors": [[4, 5, {"name": [1, "gate"]}]],
    "walls": [[4, 5, {}]],
    "fiducials": [[0.0, 0.0, "A"], [100.0, 0.0, "B"]],
}


def building(*, levels: Mapping[str, Any] | None = None, **members: Any) -> bytes:
    return yaml.safe_dump({"name": "shop", "levels": levels or {"L1": FLOOR}, "lifts": {}} | members).encode()


def test_lanes_are_in_metres_with_y_upwards() -> None:
    zones, report = import_graph(building(), "shop.building.yaml")
    assert segments_of(zones) == {
        ((5.0, -10.0), (15.0, -10.0)),
        ((15.0, -10.0), (5.0, -10.0)),
        ((15.0, -10.0), (15.0, -5.0)),
    }
    rules = {zone.name: zone.rule for zone in zones.zones}
    assert rules["0.4 m/s"] == SpeedZone(name="0.4 m/s", max_speed=0.4)
    assert rules["ramp 2"].uses == ["charge", "dock"]
    assert rules["ramp"] == Capacity(name="ramp", robots=1)
    assert texts(report, TRANSLATED)["levels.L1.measurements"] == "a pixel is 0.05 m, by 1 measurements; y upwards"
    nothing = texts(report, NO_EFFECT)
    assert nothing["graph 3"] == "1 lanes of another fleet; import them with --graph 3"
    assert texts(report, TRANSLATED)["levels.L1.doors[0] gate"] == "a door; lanes lead through it: levels.L1.lanes[0]"
    assert rules["gate"] == Door(name="gate")
    assert rules["d"] == Dock(name="d", yaw=0.0, charges=True)
    assert nothing["levels.L1.vertices[3] corner"] == "on no lane of this graph"
    assert nothing["levels.L1.walls"] == "the grid of the map has the walls"
    assert nothing["levels.L1.lanes[0].orientation"] == "robots choose their heading along lanes"


def test_another_graph_is_chosen() -> None:
    zones, _ = import_graph(building(), "shop", GraphOptions(graph=3))
    assert segments_of(zones) == {((15.0, -5.0), (5.0, -10.0))}


def test_places_to_pass_are_zones_without_stops() -> None:
    vertices = [[*VERTICES[0], {"is_passthrough_point": [4, True], "flag": [1, "x"]}], *VERTICES[1:]]
    zones, report = import_graph(building(levels={"L1": FLOOR | {"vertices": vertices}}), "shop")
    assert NoStop(name="places to pass") in [zone.rule for zone in zones.zones]
    assert texts(report, NO_EFFECT)["levels.L1.vertices[0].flag"] == "no property of Open-RMF that is known here"


LIFT = {
    "x": 100.0, "y": 100.0, "yaw": 0.0, "width": 2.0, "depth": 3.0, "reference_floor_name": "L1",
    "doors": {
        "front": {"x": 0.25, "y": 1.6, "width": 1.0, "motion_axis_orientation": 0.0},
        "right": {"x": 1.0, "y": 0.0, "width": 0.8, "motion_axis_orientation": 1.57},
    },
    "level_doors": {"L1": ["front"], "L2": ["right", "front"]},
}  # fmt: skip


def marks(kind: str, zones: Any) -> dict[str, Any]:
    return {zone.name: zone for zone in zones.zones if zone.rule.__struct_config__.tag == kind}


def test_lifts_are_cars_and_landing_doors_on_the_floors_that_they_serve() -> None:
    content = building(levels={"L1": FLOOR, "L2": FLOOR, "L3": FLOOR}, lifts={"north": LIFT})
    zones, report = import_graph(content, "shop", GraphOptions(level="L1"))
    assert texts(report, TRANSLATED)["lifts.north"] == "a car of 2 × 3 m that stops on L1, L2"
    [car] = marks("lift", zones).values()
    assert car.rule == LiftCar(name="north", lift="north")
    assert car.geometry.coordinates == [[[4.0, -6.5], [6.0, -6.5], [6.0, -3.5], [4.0, -3.5], [4.0, -6.5]]]
    door = marks("door", zones)["north front"]
    assert door.rule.lift == "north"
    assert door.geometry.coordinates == [[4.75, -3.45], [5.75, -3.45]]
    upper, _ = import_graph(content, "shop", GraphOptions(level="L2"))
    assert marks("door", upper)["north right"].geometry.coordinates == [[6.05, -5.4], [6.05, -4.6]]
    assert {"north right", "north front", "gate"} == marks("door", upper).keys()
    without, _ = import_graph(content, "shop", GraphOptions(level="L3"))
    assert marks("lift", without) == {}


def test_the_heading_of_a_lift_turns_its_car_and_doors() -> None:
    zones, _ = import_graph(building(lifts={"north": LIFT | {"yaw": 1.5707963}}), "shop")
    door = marks("door", zones)["north front"]
    assert door.geometry.coordinates == [[3.45, -5.25], [3.45, -4.25]]


@pytest.mark.parametrize(
    ("change", "part", "text"),
    [
        ({"x": None}, "lifts.north", "a lift has x, y, width and depth"),
        ({"depth": 0.0}, "lifts.north", "a lift has x, y, width and depth"),
        ({"reference_floor_name": "L9"}, "lifts.north", "its reference_floor_name 'L9' is no level: it may be L1"),
        ({"level_doors": {"L9": ["front"]}}, "lifts.north.level_doors.L9", "no such level: there are L1"),
        ({"level_doors": {"L1": ["back"]}}, "lifts.north.level_doors.L1", "the lift has no door 'back' with x, y"),
    ],
)
def test_lifts_that_are_wrong_are_refused(change: dict[str, Any], part: str, text: str) -> None:
    _, report = import_graph(building(lifts={"north": LIFT | change}), "shop")
    assert texts(report, REFUSED)[part].startswith(text)


@pytest.mark.parametrize("junk", [None, 3.7, "x", [1], {"a": 1}, {"north": 3}, {"north": {"x": "y"}}])
def test_any_values_of_lifts_are_read(junk: object) -> None:
    zones, _ = import_graph(building(lifts=junk), "shop")
    assert marks("lift", zones) == {}


def test_docks_have_the_heading_of_a_lane_that_ends_there() -> None:
    charger = {"is_charger": [4, True]}
    vertices = [[0.0, 0.0, 0, "a"], [0.0, 100.0, 0, "b", charger], [100.0, 0.0, 0, "", charger]]
    lanes = [[0, 1, {"bidirectional": [4, True], "orientation": [1, "backward"]}], [2, 0, {}]]
    floor = FLOOR | {"vertices": vertices, "lanes": lanes, "measurements": [], "doors": []}
    zones, report = import_graph(building(levels={"L1": floor}), "shop")
    [dock] = marks("dock", zones).values()
    assert (dock.name, dock.rule.charges) == ("b dock", True)
    assert dock.rule.yaw == pytest.approx(1.5708)  # backwards along -y
    assert texts(report, NO_EFFECT)["levels.L1.vertices[2] v2 dock"].startswith("no lane leads to it")


def test_other_floors_take_scale_and_turn_from_fiducials() -> None:
    # Half as many pixels a metre, turned by a quarter, and shifted.
    upper = FLOOR | {"fiducials": [[10.0, 20.0, "A"], [10.0, 70.0, "B"], [0.0, 0.0, "C"]], "measurements": []}
    content = building(levels={"L1": FLOOR, "L2": upper})
    graph, report = read_graph(content, "shop", GraphOptions(level="L2"))
    text = texts(report, TRANSLATED)["levels.L2.fiducials"]
    assert text == "scale 0.1 m and rotation 90.00° by 2 fiducials in common with L1, which are 0.000 m apart at most"
    # (0, 0) and (100, 0) of L1 are (0, 0) and (5, 0) in metres.
    assert graph.nodes["0"].place == pytest.approx(((200.0 - 20.0) * 0.1, (100.0 - 10.0) * 0.1))
    assert texts(report, NO_EFFECT)["levels.L1"] == "another floor; import it with --level L1"


@pytest.mark.parametrize("names", [["A"], []])
def test_a_floor_without_common_fiducials_takes_its_measurements(names: list[str]) -> None:
    upper = FLOOR | {"fiducials": [[10.0, 20.0, name] for name in names]}
    graph, report = read_graph(building(levels={"L1": FLOOR, "L2": upper}), "shop", GraphOptions(level="L2"))
    assert "Open-RMF would stay in pixels" in texts(report, TRANSLATED)["levels.L2.fiducials"]
    shift = (-0.5, 1.0) if names else (0.0, 0.0)
    assert graph.nodes["0"].place == pytest.approx((5.0 + shift[0], -10.0 + shift[1]))


def test_a_floor_without_measurements_has_the_scale_of_the_editor() -> None:
    content = building(levels={"L1": FLOOR | {"measurements": []}})
    graph, report = read_graph(content, "shop")
    assert graph.nodes["0"].place == pytest.approx((5.0, -10.0))
    text = "a pixel is 0.05 m, as in a new file of the editor, since it has no measurements: if that is wrong, give"
    assert texts(report, TRANSLATED)["levels.L1.measurements"].startswith(text)
    graph, _ = read_graph(content, "shop", GraphOptions(scale=0.1))
    assert graph.nodes["0"].place == pytest.approx((10.0, -20.0))
    content = building(levels={"L1": FLOOR, "L2": FLOOR | {"measurements": [], "fiducials": []}})
    graph, report = read_graph(content, "shop", GraphOptions(level="L2"))
    assert graph.nodes["0"].place == pytest.approx((5.0, -10.0))
    assert "a pixel is 0.05 m, as on L1, and the rotation" in texts(report, TRANSLATED)["levels.L2.fiducials"]


def test_metres_and_coordinates_of_the_earth() -> None:
    graph, _ = read_graph(building(coordinate_system="cartesian_meters"), "shop")
    assert graph.nodes["0"].place == (100.0, 200.0)
    earth = [[103.78, 1.30, 0.0, "a"], [103.7805, 1.3003, 0.0, "b"]]
    content = building(
        levels={"L1": {"vertices": earth, "lanes": [[0, 1, {}]]}},
        coordinate_system="wgs84",
        parameters={"generate_crs": [1, "EPSG:3414"], "suggested_offset_x": [3, 22000.0]},
    )
    graph, report = read_graph(content, "campus")
    assert graph.nodes["0"].place == pytest.approx((-4.4, 31375.8), abs=150)
    assert "less the suggested offset (22000, 0)" in texts(report, TRANSLATED)["coordinate_system"]
    graph, _ = read_graph(content, "campus", GraphOptions(anchor=(1.30, 103.78)))
    assert graph.nodes["1"].place == pytest.approx((55.65, 33.17), abs=0.1)
    with pytest.raises(InvalidInput, match="coordinate_system 'mars' is not known"):
        read_graph(building(coordinate_system="mars"), "shop")


def test_tiles_of_the_web_are_the_same_places_as_degrees() -> None:
    content = building(
        levels={"L1": {"vertices": [[128.0, 128.0, 0, "zero"], [128.001, 127.999, 0, ""]], "lanes": [[0, 1, {}]]}},
        coordinate_system="web_mercator",
    )
    graph, _ = read_graph(content, "tiles", GraphOptions(anchor=(0.0, 0.0)))
    assert graph.nodes["0"].place == pytest.approx((0.0, 0.0), abs=1e-6)
    assert graph.nodes["1"].place == pytest.approx((156.5, 155.5), abs=0.5)


def test_what_is_wrong_is_refused_and_the_rest_is_taken() -> None:
    floor = FLOOR | {"lanes": [*LANES, "lane", [0, 99, {}]], "vertices": [*VERTICES, "vertex"], "doors": ["door"]}
    graph, report = read_graph(building(levels={"L1": floor}), "shop")
    assert len(graph.edges) == 3
    refused = texts(report, REFUSED)
    assert refused["levels.L1.lanes[3]"] == "a lane is [from, to, {…}]"
    assert refused["levels.L1.lanes[4]"] == "no node has the id 99"
    assert refused["levels.L1.vertices[6]"] == "a vertex is [x, y, z, name, {…}]"
    assert refused["levels.L1.doors[0]"] == "a door is [from, to, {…}]"


@pytest.mark.parametrize("junk", [None, 3.7, "x", {"a": 1}, [[float("inf"), 0, {}]], [[1e308, 1e308, 0, "far"]] * 7])
@pytest.mark.parametrize("name", ["vertices", "lanes", "measurements", "doors", "fiducials"])
def test_any_values_of_a_floor_are_read(name: str, junk: object) -> None:
    zones, report = import_graph(building(levels={"L1": FLOOR | {name: junk}}), "shop")
    assert report.entries
    assert len(segments_of(zones)) == (0 if name in ("vertices", "lanes") else 3)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"levels: [", "no YAML: line 2"),
        (b"- 1\n- 2\n", "no mapping with levels"),
        (b"levels: {}\nname: x\n", "has no levels"),
        (b"amcl:\n  ros__parameters: {}\n", "is YAML, but no graph: this takes a route graph of Nav2"),
        (b"levels: {L1: {vertices: []}}\n&a : *b\n", "no YAML"),
    ],
)
def test_files_that_are_no_buildings_are_refused(content: bytes, reason: str) -> None:
    with pytest.raises(InvalidInput, match=reason):
        read_graph(content, "shop.yaml")


@pytest.mark.parametrize(
    ("name", "level", "lanes"), [("office", "L1", 60), ("hotel", "L1", 40), ("hotel", "L2", 32), ("campus", "L1", 181)]
)
def test_real_buildings_are_read(data: Path, name: str, level: str, lanes: int) -> None:
    content = (data / "buildings" / f"{name}.building.yaml").read_bytes()
    zones, report = import_graph(content, name, GraphOptions(level=level))
    assert texts(report, REFUSED) == {}
    assert texts(report, TRANSLATED)[f"{lanes} edges"]
    assert len(segments_of(zones)) == lanes
    if (name, level) == ("hotel", "L2"):
        text = texts(report, TRANSLATED)["levels.L2.fiducials"]
        assert text.startswith("scale 0.0561986 m and rotation 0.05° by 3 fiducials")
        assert "0.044 m apart at most" in text
