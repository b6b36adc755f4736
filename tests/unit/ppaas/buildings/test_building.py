"""Records of buildings: what is read comes back, and what is wrong is refused with its reason."""

import json
from typing import Any

import pytest

from ppaas.buildings.building import MOST_FLOORS, Building, Floor, LiftSettings, building_of, json_of
from ppaas.errors import InvalidBuilding

HOTEL: dict[str, Any] = {
    "floors": [
        {"name": "L1", "map": "hotel-1"},
        {"name": "L2", "map": "hotel-2", "elevation": 10.0, "anchor": [1.0, 0.0, 0.1]},
    ],
    "lifts": [{"lift": "north", "robots": 2, "device": "sim:"}],
    "doors": [{"floor": "L1", "door": "main", "opens": 5.0}],
    "ways": [{"way": "stairs 1", "kind": "stairs", "labels": {"legs": "4"}, "one_way": "L2"}],
}


def test_a_building_is_read_and_written() -> None:
    building = building_of(json.dumps(HOTEL))
    assert building_of(json_of(building)) == building
    assert building.floor("L2").anchor == (1.0, 0.0, 0.1)
    assert building.floor_of_map("hotel-1") == building.floors[0]
    assert building.floor_of_map("other") is None


def test_parts_without_settings_have_the_usual_ones() -> None:
    building = Building(floors=(Floor(name="L1", map="a"),))
    assert building.lift("south") == LiftSettings(lift="south")
    assert building.door("L1", "x").device == ""
    assert building.way("y").kind == "ramp"


WRONG = {
    "nothing": ("", "is not valid JSON"),
    "no floors": ({"floors": []}, "must have floors"),
    "a misspelt member": ({**HOTEL, "lift": []}, "unknown field `lift`"),
    "two floors of one name": ({"floors": [{"name": "L1", "map": "a"}, {"name": "L1", "map": "b"}]}, "'L1'"),
    "two floors with one map": ({"floors": [{"name": "L1", "map": "a"}, {"name": "L2", "map": "a"}]}, "the map 'a'"),
    "two lifts of one name": ({**HOTEL, "lifts": [{"lift": "n"}, {"lift": "n"}]}, "2 lifts have the id 'n'"),
    "a door of no floor": ({**HOTEL, "doors": [{"floor": "L9", "door": "x"}]}, "no floor 'L9'; the floors are L1, L2"),
    "a way from no floor": ({**HOTEL, "ways": [{"way": "w", "one_way": "L9"}]}, "no floor 'L9'"),
    "an elevation in space": ({"floors": [{"name": "L1", "map": "a", "elevation": 1e9}]}, "its elevation must be"),
    "an anchor of two numbers": ({"floors": [{"name": "L1", "map": "a", "anchor": [1, 2]}]}, "length 3"),
    "an anchor far away": ({"floors": [{"name": "L1", "map": "a", "anchor": [1e9, 0, 0]}]}, "its anchor must be"),
    "too many floors": ({"floors": [{"name": f"L{at}", "map": f"m{at}"} for at in range(MOST_FLOORS + 1)]}, "may have"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_refused(case: str) -> None:
    given, reason = WRONG[case]
    with pytest.raises(InvalidBuilding, match=reason):
        building_of(given if isinstance(given, str) else json.dumps(given))
