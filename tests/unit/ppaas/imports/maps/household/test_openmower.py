import msgspec
import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.common.imported_map import MapOptions
from ppaas.imports.maps.household.openmower import import_openmower
from ppaas.imports.report import ImportOutcome
from ppaas.maps.georeference import GeoAnchor
from ppaas.maps.grid import FREE, OCCUPIED


def square(x, y, side):
    return [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]


def outline(corners):
    return [{"x": x, "y": y} for x, y in corners]


def area(kind, corners, **properties):
    return {"id": "a", "properties": {"type": kind, **properties}, "outline": outline(corners)}


LAWN, BED, SHED = square(0, 0, 10), square(4, 4, 2), square(20, 0, 2)
NATIVE = {
    "areas": [
        area("mow", LAWN, name="lawn"),
        area("nav", square(10, 4, 2)),
        area("obstacle", BED, name="bed"),
        area("mow", SHED, active=False),
        area("draft", SHED),
        area("obstakle", SHED),
        area("mow", SHED[:2]),
    ],
    "docking_stations": [{"id": "d", "position": {"x": 1, "y": 2}, "heading": 0.5}],
}


def points(corners):
    return {"Points": [{"X": x, "Y": y, "Z": 0} for x, y in corners]}


BACKUP = {
    "WorkingArea": [{"Name": "lawn", "Area": points(LAWN), "Obstacles": [points(BED)]}],
    "NavigationAreas": [{"Name": "", "Area": points(square(10, 4, 2)), "Obstacles": None}],
    "DockX": 1.0, "DockY": 2.0, "DockHeading": 0.5,
}  # fmt: skip
ANCHOR = GeoAnchor(52.0, 13.0)


def degrees(corners):
    places = [ANCHOR.to_earth(x, y) for x, y in corners]
    return [[[longitude, latitude] for latitude, longitude in [*places, places[0]]]]


def feature(kind, corners):
    geometry = {"type": "Polygon", "coordinates": degrees(corners)}
    return {"type": "Feature", "properties": {"type": kind, "name": kind}, "geometry": geometry}


GEOJSON = {
    "type": "FeatureCollection",
    "features": [
        feature("operation", LAWN),
        feature("navigation", square(10, 4, 2)),
        feature("exclusion", BED),
        {"type": "Feature", "properties": {"type": "docking_station"}, "geometry": {"type": "LineString"}},
    ],
}


@pytest.mark.parametrize("tree", [NATIVE, BACKUP, GEOJSON], ids=["native", "backup", "geojson"])
def test_areas_are_free_and_obstacles_are_zones(tree):
    imported, report = import_openmower(msgspec.json.encode(tree), "lawn.json", MapOptions(resolution=0.1))
    grid = imported.grid

    def at(x, y):
        cell = grid.info.cell_of(x, y)
        return None if cell is None else int(grid.data[cell])

    assert [at(2, 2), at(11, 5), at(5, 5), at(-0.5, 5), at(11, 8)] == [FREE, FREE, OCCUPIED, OCCUPIED, OCCUPIED]
    free = (grid.data == FREE).sum() * 0.01
    assert free == pytest.approx(100 + 4 - 4, abs=2.5)
    [zone] = imported.zones.zones
    assert np.allclose(zone.area.low, (4, 4), atol=0.02) and np.allclose(zone.area.high, (6, 6), atol=0.02)
    assert any("dock" in entry.part.lower() for entry in report.of(ImportOutcome.NO_EFFECT))


def test_degrees_give_the_georeference():
    imported, _ = import_openmower(msgspec.json.encode(GEOJSON), "lawn.geojson")
    assert (imported.anchor.latitude, imported.anchor.longitude) == pytest.approx((52.0, 13.0), abs=1e-5)
    given, _ = import_openmower(msgspec.json.encode(GEOJSON), "lawn.geojson", MapOptions(anchor=ANCHOR))
    assert given.anchor == ANCHOR


def test_areas_without_effect_are_reported_each():
    _, report = import_openmower(msgspec.json.encode(NATIVE), "map.json")
    reasons = {entry.part[:8]: (entry.outcome, entry.text) for entry in report.entries}
    assert "switched off" in reasons["areas[3]"][1]
    assert "draft" in reasons["areas[4]"][1]
    assert reasons["areas[5]"][0] is ImportOutcome.REFUSED and "did you mean 'obstacle'" in reasons["areas[5]"][1]
    assert reasons["areas[6]"][0] is ImportOutcome.REFUSED and "three points" in reasons["areas[6]"][1]


def test_an_outline_driven_with_gps_becomes_a_zone_with_few_corners():
    angles = np.linspace(0.0, 2.0 * np.pi, 3000, endpoint=False)
    pond = (5.0 + 2.0 * np.stack((np.cos(angles), np.sin(angles)), axis=1)).tolist()
    tree = {"areas": [area("mow", LAWN), area("obstacle", pond, name="pond")]}
    imported, _ = import_openmower(msgspec.json.encode(tree), "map.json")
    [zone] = imported.zones.zones
    assert zone.name == "pond" and len(zone.geometry.coordinates[0]) < 100


@pytest.mark.parametrize(
    ("tree", "reason"),
    [
        ({"a": 1}, "not a map of OpenMower"),
        ({"areas": [area("obstacle", LAWN)]}, "no area in which"),
        ({"areas": [area("mow", square(-9000, -9000, 18000))]}, "cells"),
        ({"areas": [{"properties": {"type": "mow"}, "outline": [{"x": 1}, {"x": "a"}, 3]}]}, "no area in which"),
    ],
)
def test_a_map_without_free_space_is_refused(tree, reason):
    with pytest.raises(InvalidMap, match=reason):
        import_openmower(msgspec.json.encode(tree), "map.json")
