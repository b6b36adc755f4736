"""Navigation graphs of Open-RMF, which are in metres already."""

from typing import Any

import pytest
import yaml

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.imports.graphs.reading import import_graph, read_graph
from ppaas.zones.zone import Door
from tests.support.graphs import NO_EFFECT, REFUSED, segments_of, texts

DOORS = {
    "gate": {"endpoints": [[3.0, -1.5], [3.0, -2.5]], "map": "L1"},
    "below": {"endpoints": [[3.0, -1.5], [3.0, -2.5]], "map": "B1"},
    "stump": {"endpoints": [[3.0, -1.5]]},
}


def nav_graph(**members: Any) -> bytes:
    floor = {
        "vertices": [
            [1.5, -2.0, {"name": "ramp", "is_holding_point": True}],
            [4.5, -2.0, {"name": ""}],
            [4.5, -6.0, {"name": ""}],
        ],
        "lanes": [
            [0, 1, {"is_bidirectional": True, "door_name": "gate"}],
            [1, 2, {"speed_limit": 0.3}],
            [2, 7, {}],
            "x",
        ],
    }
    return yaml.safe_dump(
        {"building_name": "shop", "levels": {"B1": {"lanes": [], "vertices": []}, "L1": floor}} | members
    ).encode()


def test_lanes_are_one_way_unless_they_say_otherwise() -> None:
    zones, report = import_graph(nav_graph(doors=DOORS, offset=[1, 2]), "0.yaml")
    assert segments_of(zones) == {((1.5, -2.0), (4.5, -2.0)), ((4.5, -2.0), (1.5, -2.0)), ((4.5, -2.0), (4.5, -6.0))}
    assert [zone.rule.uses for zone in zones.stations] == [["wait"]]
    nothing, refused = texts(report, NO_EFFECT), texts(report, REFUSED)
    assert nothing["levels.B1"] == "another floor, without lanes; import it with --level B1"
    assert nothing["levels.L1.lanes[0].door_name"].startswith("doors are lines across the way")
    assert "offset" in nothing
    assert [zone.name for zone in zones.zones if isinstance(zone.rule, Door)] == ["gate"]
    assert refused["doors.stump"] == "a door has two endpoints, each [x, y]"
    assert refused["levels.L1.lanes[2]"] == "no node has the id 7"
    assert refused["levels.L1.lanes[3]"] == "a lane is [from, to, {…}]"


def test_names_of_the_first_versions_stand_alone() -> None:
    floor = {"vertices": [[0.0, 0.0, "dock"], [4.0, 0.0, ""]], "lanes": [[0, 1, {}]]}
    graph, _ = read_graph(yaml.safe_dump({"levels": {"L1": floor}}).encode(), "0.yaml")
    assert [(each.name, each.place) for each in graph.stations] == [("dock", (0.0, 0.0))]


def test_a_floor_is_chosen_by_name() -> None:
    with pytest.raises(InvalidInput, match="has no level 'L9': it has B1, L1"):
        read_graph(nav_graph(), "0.yaml", GraphOptions(level="L9"))
