import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_yaml import parse_yaml
from ppaas.maps.georeference import GeoAnchor, anchor_of, with_anchor

RECORD = b"image: yard.pgm\nresolution: 0.1\norigin: [-4.0, 2.0, 0.0]\n"
METRES = st.floats(-20_000.0, 20_000.0)
ANCHORS = st.builds(GeoAnchor, st.floats(-89.0, 89.0), st.floats(-180.0, 180.0), st.floats(-math.pi, math.pi))


@given(ANCHORS, METRES, METRES)
def test_a_point_of_the_map_is_found_again(anchor, x, y):
    assert anchor.to_map(*anchor.to_earth(x, y)) == pytest.approx((x, y), abs=1e-5)


# Reference: topocentric coordinates of PROJ 9.5.1 (`+proj=topocentric +ellps=WGS84`), to 0.1 mm.
PROJ = [
    (GeoAnchor(52.0, 13.0), (52.01, 13.02), (1373.2542, 1112.8633)),
    (GeoAnchor(-33.9, 151.2), (-33.9005, 151.1991), (-83.2431, -55.4607)),
    (GeoAnchor(0.0, 180.0), (0.0003, -179.9995), (55.6597, 33.1723)),
    (GeoAnchor(78.2, 15.6), (78.19, 15.65), (1142.8415, -1115.9792)),
]


@pytest.mark.parametrize(("anchor", "place", "expected"), PROJ)
def test_points_are_where_proj_has_them(anchor, place, expected):
    assert anchor.to_map(*place) == pytest.approx(expected, abs=2e-4)


def test_the_x_axis_points_to_the_yaw():
    north = GeoAnchor(47.4, 8.5, math.pi / 2)
    x, y = north.to_map(47.401, 8.5)
    assert (x, y) == pytest.approx((111.18, 0.0), abs=0.05)


@given(ANCHORS, st.floats(-500.0, 500.0), st.floats(-500.0, 500.0), st.floats(-3.0, 3.0))
def test_a_moved_frame_sees_the_same_earth(anchor, x, y, turn):
    moved = anchor.moved(x, y, turn)
    there = moved.to_map(*anchor.to_earth(x + 3.0 * math.cos(turn), y + 3.0 * math.sin(turn)))
    assert there == pytest.approx((3.0, 0.0), abs=1e-3)


def test_a_record_keeps_its_georeference():
    anchor = GeoAnchor(48.137154, 11.576124, -0.25)
    record = with_anchor(RECORD, anchor)
    assert anchor_of(record) == anchor
    assert parse_yaml(record) == parse_yaml(RECORD)
    assert anchor_of(RECORD) is None


@pytest.mark.parametrize("value", ["[1.0, 2.0]", "here", "[1, 2, north]", "[95.0, 2.0, 0.0]", "[.nan, 0, 0]", "{a: 1}"])
def test_an_invalid_georeference_is_refused(value):
    with pytest.raises(InvalidMap, match="georeference"):
        anchor_of(RECORD + f"georeference: {value}\n".encode())


def test_a_point_beside_the_earth_is_refused():
    with pytest.raises(InvalidMap, match="too far"):
        GeoAnchor(10.0, 20.0).to_earth(7e6, 0.0)
