"""Cells that areas touch, against the same by each cell alone."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.maps.grid import GridInfo
from ppaas.planar_poses import Pose2D
from ppaas.zones.masks import kept_out, touched
from ppaas.zones.shapes import Area, Geometry, LineString, Polygon
from ppaas.zones.zone import KeepOut, NoStop, Zone
from tests.support.world.zones import areas, ways

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
