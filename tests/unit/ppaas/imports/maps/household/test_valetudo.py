import msgspec
import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.maps.household.valetudo import MARGIN, import_valetudo
from ppaas.imports.report import ImportOutcome
from ppaas.maps.georeference import GeoAnchor
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN


def valetudo(layers, entities=(), **others):
    tree = {"size": {"x": 1000, "y": 400}, "pixelSize": 5, "layers": layers, "entities": list(entities)}
    return msgspec.json.encode(tree | others)


FLOOR = {"type": "floor", "compressedPixels": [10, 20, 3, 10, 21, 3]}
WALL = {"type": "wall", "compressedPixels": [9, 20, 1, 13, 20, 1]}


def outcome_of(report, part):
    return next(entry for entry in report.entries if entry.part.startswith(part))


def test_runs_become_cells_with_y_up():
    imported, _ = import_valetudo(valetudo([FLOOR, WALL]), "home.json")
    grid = imported.grid
    assert grid.info.resolution == 0.05
    inner = grid.data[MARGIN:-MARGIN, MARGIN:-MARGIN]
    assert inner.tolist() == [[UNKNOWN, FREE, FREE, FREE, UNKNOWN], [OCCUPIED, FREE, FREE, FREE, OCCUPIED]]
    # The pixel (10, 21), from the top left, is from 0.5 m to 0.55 m and from 4 m − 1.1 m on.
    assert grid.info.cell_of(0.525, 4.0 - 1.075) == (MARGIN, MARGIN + 1)


def test_the_frame_is_that_of_the_robot_however_much_it_has_seen():
    more = {"type": "segment", "metaData": {"segmentId": 7, "name": "Kitchen"}, "compressedPixels": [40, 50, 5]}
    small, _ = import_valetudo(valetudo([FLOOR]), "a")
    large, report = import_valetudo(valetudo([FLOOR, more]), "b")
    for place in ((0.525, 2.925), (0.625, 2.975)):
        assert small.grid.data[small.grid.info.cell_of(*place)] == FREE
        assert large.grid.data[large.grid.info.cell_of(*place)] == FREE
    assert outcome_of(report, "layers[1] segment Kitchen").text == "5 free cells"


def test_pixels_one_by_one_are_those_of_older_versions():
    plain = {"type": "floor", "pixels": [10, 20, 11, 20, 12, 20, 10, 21, 11, 21, 12, 21]}
    old, _ = import_valetudo(valetudo([plain, WALL]), "old")
    new, _ = import_valetudo(valetudo([FLOOR, WALL]), "new")
    assert np.array_equal(old.grid.data, new.grid.data)


def test_areas_and_walls_become_zones_and_all_else_is_reported():
    entities = [
        {"type": "no_go_area", "points": [50, 100, 65, 100, 65, 110, 50, 110]},
        {"type": "virtual_wall", "points": [50, 100, 50, 110]},
        {"type": "charger_location", "points": [50, 100]},
        {"type": "robot_position", "metaData": {"angle": 90}, "points": [55, 105]},
        {"type": "carpet", "points": [0, 0, 10, 0, 10, 10]},
        {"type": "no_mop_area", "points": [0, 0, 10, 0, 10, 10]},
        {"type": "no_go_aera", "points": [0, 0]},
        {"type": "no_go_area", "points": [1, 2, 3]},
    ]
    imported, report = import_valetudo(valetudo([FLOOR, WALL], entities), "home.json")
    area, wall = imported.zones.zones
    assert area.geometry.coordinates == [[[0.5, 3.0], [0.65, 3.0], [0.65, 2.9], [0.5, 2.9], [0.5, 3.0]]]
    assert {tuple(corner) for corner in wall.geometry.coordinates[0]} == {
        (0.45, 3.0), (0.55, 3.0), (0.45, 2.9), (0.55, 2.9),
    }  # fmt: skip
    found = [entry.outcome for entry in report.entries if entry.part.startswith("entities")]
    assert found == [ImportOutcome.TRANSLATED] * 2 + [ImportOutcome.NO_EFFECT] * 4 + [ImportOutcome.REFUSED] * 2
    assert "x=0.55, y=2.95, yaw=0.00" in outcome_of(report, "entities[3]").text
    assert "did you mean 'no_go_area'" in outcome_of(report, "entities[6]").text


def test_a_state_of_a_robot_has_a_map_in_it():
    state = msgspec.json.encode({"attributes": [], "map": msgspec.json.decode(valetudo([FLOOR]))})
    assert import_valetudo(state, "state.json")[0].grid.data.max() == FREE


def test_a_georeference_may_be_given():
    anchor = GeoAnchor(48.0, 11.0, 0.5)
    assert import_valetudo(valetudo([FLOOR]), "a", MapOptions(anchor=anchor))[0].anchor == anchor


@pytest.mark.parametrize(
    ("layer", "reason"),
    [
        ({"type": "lava", "compressedPixels": [1, 1, 1]}, "unknown layer"),
        ({"type": "wall", "compressedPixels": [1, 1]}, "3 for each"),
        ({"type": "wall", "compressedPixels": [1, 1, 0.5]}, "whole numbers"),
        ({"type": "wall", "compressedPixels": [1, 1, 1_000_000_000]}, "outside of any map"),
        ({"type": "wall", "compressedPixels": [1, 1, 10**30]}, "whole numbers"),
        ({"type": "wall", "compressedPixels": []}, "no pixels"),
        ("wall", "unknown layer"),
    ],
)
def test_a_layer_that_is_not_valid_is_refused_alone(layer, reason):
    imported, report = import_valetudo(valetudo([FLOOR, layer]), "home.json")
    entry = outcome_of(report, "layers[1]")
    assert (entry.outcome, reason in entry.text) == (ImportOutcome.REFUSED, True)
    assert (imported.grid.data == FREE).sum() == 6


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"{}", "not a map of Valetudo"),
        (valetudo([WALL]), "no cell is free"),
        (valetudo([FLOOR], pixelSize="wide"), "pixelSize"),
        (valetudo([{"type": "floor", "compressedPixels": [0, 0, 1, 1_000_000, 1_000_000, 1]}]), "cells"),
    ],
)
def test_a_map_that_is_none_is_refused(content, reason):
    with pytest.raises(InvalidMap, match=reason):
        import_valetudo(content, "home.json")


def test_a_real_map_is_imported(data):
    content = (data / "foreign" / "valetudo.json").read_bytes()
    imported, report = import_valetudo(content, "valetudo.json")
    tree = msgspec.json.decode(content)
    counts = {True: 0, False: 0}
    for layer in tree["layers"]:
        counts[layer["type"] == "wall"] += layer["dimensions"]["pixelCount"]
    assert (imported.grid.data == OCCUPIED).sum() == counts[True]
    assert (imported.grid.data == FREE).sum() == counts[False]
    assert not list(report.of(ImportOutcome.REFUSED))
    assert imported.grid.info.origin == Pose2D(20.5, 24.7, 0.0)
