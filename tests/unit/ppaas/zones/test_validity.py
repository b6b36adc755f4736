"""Geometries of zones: valid, mended with a word, or refused with the place."""

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given

from ppaas.errors import InvalidZones
from ppaas.zones.gate import CheckedZones, checked_zones
from ppaas.zones.shapes import Area, Geometry, MultiPolygon, Polygon
from ppaas.zones.validity import outline_fault
from tests.support.geojson import collection, feature
from tests.support.world.zones import areas


def square(x: float, y: float, size: float) -> list[list[float]]:
    return [[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]]


def polygon(*rings: Any) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": list(rings)}


def polygons(*parts: Any) -> dict[str, Any]:
    return {"type": "MultiPolygon", "coordinates": list(parts)}


def line(*places: Any) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": list(places)}


def lines(*parts: Any) -> dict[str, Any]:
    return {"type": "MultiLineString", "coordinates": list(parts)}


def checked(geometry: Any, **properties: Any) -> CheckedZones:
    return checked_zones(collection(feature(geometry, name="server room", **properties)))


BOW_TIE = [[8.5, 6.2], [11.8, 9.8], [11.8, 6.2], [8.5, 9.8], [8.5, 6.2]]
BIG = square(0, 0, 10)
ONE_WAY: dict[str, Any] = {"kind": "one_way", "width": 1}
LANE: dict[str, Any] = {"kind": "lane"}
DEGREES = [[8.54, 47.37], [8.5401, 47.37], [8.5401, 47.3701], [8.54, 47.3701], [8.54, 47.37]]

WRONG: dict[str, tuple[Any, str, tuple[float, float], dict[str, Any]]] = {
    "a bow tie": (polygon(BOW_TIE), "its outline crosses itself at (10.15, 8)", (10.15, 8.0), {}),
    "a bow tie that is not closed": (polygon(BOW_TIE[:-1]), "crosses itself at (10.15, 8)", (10.15, 8.0), {}),
    "a bow tie as a speed limit": (
        polygon(BOW_TIE), "crosses itself at (10.15, 8)", (10.15, 8.0), {"kind": "speed_limit", "percent": 50}
    ),
    "an outline that touches itself": (
        polygon([[0, 0], [4, 0], [4, 4], [2, 0], [0, 4], [0, 0]]), "touches itself at (2, 0)", (2.0, 0.0), {}
    ),
    "a spike": (
        polygon([[0, 0], [4, 0], [4, 4], [4, -2], [4, 0], [0, 4], [0, 0]]), "itself at (4, 0)", (4.0, 0.0), {}
    ),
    "a crossed hole": (polygon(BIG, BOW_TIE), "a hole crosses itself at (10.15, 8)", (10.15, 8.0), {}),
    "a hole outside": (polygon(BIG, square(20, 20, 1)), "a hole lies outside of its outline at (20, 20)", (20, 20), {}),
    "a hole across the outline": (polygon(BIG, square(8, 8, 4)), "a hole crosses the outline", (8.0, 10.0), {}),
    "holes that overlap": (
        polygon(BIG, square(2, 2, 4), square(3, 3, 4)), "another hole at (6, 3)", (6.0, 3.0), {}
    ),
    "a hole in a hole": (polygon(BIG, square(2, 2, 4), square(3, 3, 1)), "a hole lies in another one", (3.0, 3.0), {}),
    "a hole that is all": (polygon(BIG, BIG), "a hole crosses the outline", (10.0, 10.0), {}),
    "a part that is crossed": (polygons([BIG], [BOW_TIE]), "crosses itself at (10.15, 8)", (10.15, 8.0), {}),
    "corners on a line": (polygon([[0, 0], [1, 1], [2, 2], [0, 0]]), "encloses no area at (0, 0)", (0.0, 0.0), {}),
    "degrees": (polygon(DEGREES), "are its positions longitudes and latitudes?", (8.54, 47.37), {}),
    "a lane in degrees": (line([8.54, 47.37], [8.5401, 47.3701]), "longitudes and latitudes?", (8.54, 47.37), LANE),
    "a lane that doubles back": (line([0, 0], [5, 0], [2, 0]), "leads back on itself at (5, 0)", (5.0, 0.0), LANE),
    "a lane that comes back later": (
        line([0, 0], [5, 0], [5, 5], [6, 0], [1, 0]), "leads back on itself at (6, 0)", (6.0, 0.0), LANE
    ),
    "a one-way line that doubles back": (
        lines([[0, 5], [1, 5]], [[0, 0], [5, 5], [2, 2]]), "itself at (5, 5)", (5.0, 5.0), ONE_WAY
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_refused_with_the_zone_and_the_place(case: str) -> None:
    geometry, text, place, properties = WRONG[case]
    with pytest.raises(InvalidZones) as caught:
        checked(geometry, **properties)
    assert "zone 'server room'" in str(caught.value)
    assert text in str(caught.value)
    (fault,) = caught.value.faults
    assert fault.zone == "server room"
    assert fault.place == pytest.approx(place)


def test_all_zones_that_are_wrong_are_named() -> None:
    crossed, outside = feature(polygon(BOW_TIE)), feature(polygon(BIG, square(20, 20, 1)), name="b")
    with pytest.raises(InvalidZones) as caught:
        checked_zones(collection(crossed, feature(name="good"), outside))
    assert [(fault.zone, fault.place) for fault in caught.value.faults] == [("a", (10.15, 8.0)), ("b", (20.0, 20.0))]


MENDED: dict[str, tuple[Any, Any, str, dict[str, Any]]] = {
    "clockwise": (polygon(BIG[::-1]), polygon(BIG), "the outline was reversed", {}),
    "a counterclockwise hole": (
        polygon(BIG, square(2, 2, 1)), polygon(BIG, square(2, 2, 1)[::-1]), "holes clockwise", {}
    ),
    "not closed": (polygon(BIG[:-1]), polygon(BIG), "the outline was closed", {}),
    "closed but for rounding": (
        polygon([*BIG[:-1], [1e-7, -1e-7]]), polygon(BIG), "the outline was closed", {}
    ),
    "an empty hole": (polygon(BIG, []), polygon(BIG), "parts without positions were left out", {}),
    "a hole of an overlay": (
        polygon(BIG, square(2, 2, 1e-4)), polygon(BIG), "enclose less than 1 cm² were left out", {}
    ),
    "a part of an overlay": (
        polygons([square(2, 2, 1e-4)], [BIG]), polygon(BIG), "enclose less than 1 cm² were left out", {}
    ),
    "an empty part of lanes": (
        lines([[0, 0], [1, 0]], []), lines([[0, 0], [1, 0]]), "parts without positions were left out", LANE
    ),
    "repeated": (polygon([BIG[0], *BIG]), polygon(BIG), "positions that follow themselves were left out", {}),
    "heights": (polygon([[*place, 1.5] for place in BIG]), polygon(BIG), "heights were left out", {}),
    "heights that are null": (polygon([[*place, None] for place in BIG]), polygon(BIG), "heights were left out", {}),
    "an empty part": (polygons([], [BIG]), polygon(BIG), "parts without positions were left out", {}),
    "parts side by side": (
        polygons([square(0, 0, 1)], [square(1, 0, 1)]), None, "parts that overlap or touch were joined", {}
    ),
    "a repeated lane": (line([0, 0], [0, 0], [1, 0]), line([0, 0], [1, 0]), "positions that follow themselves", LANE),
}  # fmt: skip


@pytest.mark.parametrize("case", MENDED)
def test_what_has_one_meaning_is_mended_with_a_word(case: str) -> None:
    given_geometry, expected, text, properties = MENDED[case]
    zones, warnings = checked(given_geometry, **properties)
    (zone,) = zones.zones
    if expected is not None:
        assert zone.geometry == checked(expected, **properties).zones.zones[0].geometry
        assert checked(expected, **properties).warnings == []
    assert any(text in warning and "'server room'" in warning for warning in warnings), warnings


def test_parts_that_overlap_become_their_union() -> None:
    zones, warnings = checked(polygons([square(0, 0, 4)], [square(2, 2, 4)], [square(20, 0, 1)]))
    area = zones.zones[0].area
    places = np.array([(1, 1), (3, 3), (5, 5), (1, 5), (20.5, 0.5)], float)
    assert (area.distances(places) == 0.0).tolist() == [True, True, True, False, True]
    assert len(area.polygons) == 2
    assert warnings == ["zone 'server room': parts that overlap or touch were joined"]


@pytest.mark.parametrize(
    ("geometry", "properties"),
    [
        (polygon(BIG, square(4, 4, 2)[::-1]), {}),
        (polygon(BIG, [[0, 5], [2, 6], [2, 4], [0, 5]]), {}),
        (polygons([BIG, square(4, 4, 2)[::-1]], [square(4.5, 4.5, 1)]), {}),
        (line([0, 0], [5, 0], [5, 5], [2, 5], [2, -5]), LANE),
        (line([0, 0], [5, 0], [0.2, 0.5]), LANE),
    ],
    ids=["a hole", "a hole that touches the outline", "an island", "a lane that crosses itself", "a sharp turn"],
)
def test_what_is_valid_stays_without_a_word(geometry: Any, properties: dict[str, Any]) -> None:
    zones, warnings = checked(geometry, **properties)
    assert warnings == []
    assert json.loads(json.dumps(geometry["coordinates"])) == zones.zones[0].geometry.coordinates


def test_an_outline_of_corners_is_checked_alone() -> None:
    assert outline_fault([(0, 0), (1, 0), (1, 1)]) == ""
    assert "crosses itself at (0.5, 0.5)" in outline_fault([(0, 0), (1, 1), (1, 0), (0, 1)])


@given(areas())
def test_what_passes_is_valid_covers_the_same_and_passes_again_unchanged(geometry: Geometry) -> None:
    shape = {"type": type(geometry).__name__, "coordinates": geometry.coordinates}
    try:
        zones, _ = checked(shape)
    except InvalidZones as error:
        assert all(fault.place is not None for fault in error.faults)
        return
    found = zones.zones[0].geometry
    assert isinstance(found, Polygon | MultiPolygon)
    again, warnings = checked({"type": type(found).__name__, "coordinates": found.coordinates})
    assert (again, warnings) == (zones, [])
    points = np.random.default_rng(0).uniform(-50, 50, (200, 2))
    np.testing.assert_allclose(Area(found).distances(points) == 0.0, Area(geometry).distances(points) == 0.0)
