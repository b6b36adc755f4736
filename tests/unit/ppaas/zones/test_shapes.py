"""Areas of zones: distances, holes, overlapping polygons, lanes and their directions; cells that areas touch."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.maps.grid import GridInfo
from ppaas.planar_poses import Pose2D
from ppaas.polygons import Points
from ppaas.zones.masks import kept_out, touched
from ppaas.zones.shapes import Area, Geometry, LineString, MultiLineString, MultiPolygon, Polygon, Ring
from ppaas.zones.zone import KeepOut, NoStop, Zone
from tests.support.world.zones import areas, positions, ways


def square(x: float, y: float, size: float) -> Ring:
    return [[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]]


HOLED = Polygon([square(0, 0, 10), square(4, 4, 2)])


@pytest.mark.parametrize(
    ("place", "distance"),
    [((1, 1), 0.0), ((10, 5), 0.0), ((12, 5), 2.0), ((13, 14), 5.0), ((5, 5), 1.0), ((4.5, 5), 0.5), ((4, 5), 0.0)],
)
def test_holes_are_outside(place: tuple[float, float], distance: float) -> None:
    assert Area(HOLED).distances(np.array([place], float))[0] == pytest.approx(distance)


def test_places_in_two_polygons_are_inside() -> None:
    area = Area(MultiPolygon([[square(0, 0, 10)], [square(5, 5, 10)], [square(4, 4, 3)]]))
    places = np.array([(6, 6), (8, 8), (1, 1), (14, 14), (1, 14)], float)
    assert area.distances(places).tolist() == [0.0, 0.0, 0.0, 0.0, 4.0]


def test_a_hole_of_one_polygon_is_filled_by_another() -> None:
    area = Area(MultiPolygon([HOLED.coordinates, [square(4, 4, 2)]]))
    assert area.distances(np.array([(5.0, 5.0)]))[0] == 0.0


def test_an_empty_polygon_among_others_is_nothing() -> None:
    area = Area(MultiPolygon([[], [square(0, 0, 1)]]))
    assert area.distances(np.array([(0.5, 0.5), (3.0, 0.5)])).tolist() == [0.0, 2.0]


def test_a_lane_is_as_wide_as_it_says() -> None:
    area = Area(LineString([[0, 0], [10, 0], [10, 10]]), width=2.0)
    places = np.array([(5, 0.5), (5, 1), (5, 3), (-1, 0), (11, 5), (13, 5)], float)
    assert area.distances(places).tolist() == [0.0, 0.0, 2.0, 0.0, 0.0, 2.0]
    assert (area.low.tolist(), area.high.tolist()) == ([-1.0, -1.0], [11.0, 11.0])


def test_directions_are_those_of_the_nearest_line() -> None:
    area = Area(MultiLineString([[[0, 0], [10, 0], [10, 10]], [[0, 20], [-5, 20]]]), width=1.0)
    places = np.array([(5, 1), (9, 8), (-1, 19)], float)
    np.testing.assert_allclose(area.directions(places), [(1, 0), (0, 1), (-1, 0)])


def test_many_places_are_considered_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    places = np.random.default_rng(1).uniform(-5, 15, (1000, 2))
    whole = Area(HOLED).distances(places)
    monkeypatch.setattr("ppaas.zones.shapes.AT_ONCE", 64)
    np.testing.assert_array_equal(Area(HOLED).distances(places), whole)
    assert Area(HOLED).distances(np.empty((0, 2))).shape == (0,)


def _within(ring: Ring, x: float, y: float) -> bool:
    inside = False
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


def _apart(a: list[float], b: list[float], x: float, y: float) -> float:
    (ax, ay), (bx, by) = a, b
    squared = (bx - ax) ** 2 + (by - ay) ** 2
    part = 0.0 if squared == 0.0 else min(1.0, max(0.0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / squared))
    return float(np.hypot(x - ax - part * (bx - ax), y - ay - part * (by - ay)))


def naive(geometry: Geometry, width: float, x: float, y: float) -> float:
    """Return the distance of a place from an area [m], edge by edge."""
    match geometry:
        case LineString() | MultiLineString():
            lines = [geometry.coordinates] if isinstance(geometry, LineString) else geometry.coordinates
            edges = [edge for line in lines for edge in pairwise(line)]
            return max(0.0, min(_apart(a, b, x, y) for a, b in edges) - width / 2)
    polygons = [geometry.coordinates] if isinstance(geometry, Polygon) else geometry.coordinates
    for outer, *holes in polygons:
        if _within(outer, x, y) and not any(_within(hole, x, y) for hole in holes):
            return 0.0
    rings = [ring for polygon in polygons for ring in polygon]
    return min(_apart(a, b, x, y) for ring in rings for a, b in zip(ring, ring[1:] + ring[:1], strict=True))


@given(areas() | ways(), st.floats(0.0, 5.0), st.lists(positions(), min_size=1, max_size=8))
def test_distances_agree_with_a_naive_twin(geometry: Geometry, width: float, places: list[list[float]]) -> None:
    points: Points = np.array(places, float) + 0.03125  # not on the grid of the corners
    found = Area(geometry, width).distances(points)
    expected = [naive(geometry, width, float(x), float(y)) for x, y in points]
    np.testing.assert_allclose(found, expected, atol=1e-9)


TRIANGLE = Polygon([[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]])

infos = st.builds(
    GridInfo,
    st.sampled_from((0.25, 1.0, 3.0)),
    st.integers(1, 12),
    st.integers(1, 12),
    st.builds(Pose2D, st.floats(-60, 60), st.floats(-60, 60), st.floats(-math.pi, math.pi)),
)


@given(infos, areas() | ways(), st.sampled_from((0.0, 0.4, 7.0)))
def test_touched_cells_are_those_whose_circle_reaches_the_area(
    info: GridInfo, geometry: Geometry, growth: float
) -> None:
    area = Area(geometry, 1.0)
    mask = touched(info, area, growth)
    cells = np.stack(np.indices(info.shape), axis=-1).reshape(-1, 2)
    distances = area.distances(info.to_world(cells)).reshape(info.shape)
    half = info.resolution * math.sqrt(0.5)
    assert mask.shape == info.shape
    assert mask[distances <= growth + half].all()
    assert not mask[distances > growth + 1.001 * half].any()


@given(infos, areas())
def test_each_cell_that_holds_a_place_of_the_area_is_touched(info: GridInfo, geometry: Geometry) -> None:
    area, mask = Area(geometry), touched(info, Area(geometry))
    inner = np.random.default_rng(0).uniform(area.low, np.maximum(area.high, area.low + 1e-9), (200, 2))
    cells = info.to_cells(inner[area.distances(inner) == 0.0])
    on_grid = ((cells >= 0) & (cells < info.shape)).all(axis=1)
    assert mask[tuple(cells[on_grid].T)].all()


def test_an_area_beyond_the_grid_touches_nothing() -> None:
    for origin in (Pose2D(50.0, 0.0, 0.0), Pose2D(-50.0, 0.0, 0.0), Pose2D(0.0, 50.0, 1.0), Pose2D(0.0, -50.0, 1.0)):
        assert not touched(GridInfo(1.0, 4, 4, origin), Area(TRIANGLE)).any()


def test_a_narrow_lane_touches_the_cells_along_it() -> None:
    mask = touched(GridInfo(1.0, 5, 3), Area(LineString([[0.5, 1.5], [4.5, 1.5]]), 0.01))
    assert mask[1].all()
    assert not mask[0].any()


@pytest.mark.parametrize("number", [0, 1, 2])
def test_robots_keep_out_of_zones_of_that_kind_only(number: int) -> None:
    info = GridInfo(1.0, 8, 8)
    zones = [Zone(TRIANGLE, NoStop(name="n"))]
    far = Polygon([[[5.0, 5.0], [6.0, 5.0], [5.0, 6.0]]])
    zones += [Zone(area, KeepOut(name=str(n))) for n, area in enumerate((TRIANGLE, far)[:number])]
    mask = kept_out(info, zones)
    if number == 0:
        assert mask is None
        return
    expected = [touched(info, zone.area) for zone in zones[1:]]
    np.testing.assert_array_equal(mask, np.logical_or.reduce(expected))
