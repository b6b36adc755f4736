"""Buildings of Open-RMF: lanes, named vertices and doors of one floor, in metres."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.imports.graphs.reading import import_graph, read_graph
from ppaas.zones.zone import Capacity, NoStop, SpeedZone
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
    assert (
        nothing["levels.L1.doors[0] gate"]
        == "robots drive on as if doors were open; lanes lead through it: levels.L1.lanes[0]"
    )
    assert nothing["levels.L1.vertices[3] corner"] == "on no lane of this graph"
    assert nothing["levels.L1.walls"] == "the grid of the map has the walls"
    assert nothing["levels.L1.lanes[0].orientation"] == "robots choose their heading along lanes"


def test_another_graph_is_chosen() -> None:
    zones, _ = import_graph(building(), "shop", GraphOptions(graph=3))
    assert segments_of(zones) == {((15.0, -5.0), (5.0, -10.0))}


def test_places_to_pass_are_zones_without_stops() -> None:
    vertices = [[*VERTICES[0], {"is_passthrough_point": [4, True], "flag": [1, "x"]}], *VERTICES[1:]]
    zones, report = import_graph(building(levels={"L1": FLOOR | {"vertices": vertices}}), "shop")
    assert zones.zones[-2].rule == NoStop(name="places to pass") or zones.zones[-1].rule == NoStop(
        name="places to pass"
    )
    assert texts(report, NO_EFFECT)["levels.L1.vertices[0].flag"] == "no property of Open-RMF that is known here"


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
