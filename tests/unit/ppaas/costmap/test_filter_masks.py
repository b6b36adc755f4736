"""Masks of costmap filters on the cells of a map."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap import filter_masks
from ppaas.costmap.filter_masks import barred, raise_costs, sampled, spread
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from tests.reference.maps import costmaps


@st.composite
def masks_and_maps(draw):
    """Draw a mask and the geometry of a map, with any relative pose in which no cell centre is on another's edge."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    height, width = draw(st.tuples(st.integers(1, 12), st.integers(1, 12)))
    values = rng.choice(np.array([-1, 0, 0, 0, 1, 50, 99, 100], np.int8), (height, width))
    origins = [Pose2D(*rng.uniform(-1.0, 1.0, 2), draw(st.sampled_from([0.0, 0.3, -math.pi / 2]))) for _ in "ab"]
    mask = GridMap(values, GridInfo(draw(st.sampled_from([0.03, 0.1, 0.5])), width, height, origins[0]))
    rows, columns = draw(st.tuples(st.integers(1, 12), st.integers(1, 12)))
    return mask, GridInfo(0.1, columns, rows, origins[1])


@given(masks_and_maps(), st.sampled_from([1, 7, 1 << 18]))
def test_masks_are_resampled_like_by_their_twins(drawn, block):
    mask, info = drawn
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(filter_masks, "_BLOCK", block)
        assert np.array_equal(sampled(mask, info).data, costmaps.sampled(mask, info))
        assert np.array_equal(spread(mask, info).data, costmaps.spread(mask, info))


def test_line_thinner_than_a_cell_is_kept():
    data = np.zeros((40, 40), np.int8)
    data[:, 17] = 100
    info = GridInfo(0.1, 10, 10)
    found = spread(GridMap(data, GridInfo(0.025, 40, 40)), info).data
    assert (found[:, 4] == 100).all()
    assert (np.delete(found, 4, axis=1) == 0).all()


def test_mask_with_the_same_cells_is_unchanged():
    data = np.random.default_rng(1).integers(0, 101, (9, 7)).astype(np.int8)
    mask = GridMap(data, GridInfo(0.05, 7, 9, Pose2D(-1.3, 2.7, 0.4)))
    assert np.array_equal(spread(mask, mask.info).data, data)
    assert np.array_equal(sampled(mask, mask.info).data, data)


@pytest.mark.parametrize("cost", [0, 1, 100, 252, 253, 254, 255])
def test_costs_are_raised_like_in_nav2_and_never_lowered(cost):
    values = np.arange(-1, 101, dtype=np.int8)[None]
    costs = np.full((1, 102), cost, np.uint8)
    raise_costs(costs, values)
    for value, raised in zip(values[0].tolist(), costs[0].tolist(), strict=True):
        if value <= 0:
            assert raised == cost
        else:
            assert raised == (costmaps.cost(value) if cost == 255 else max(cost, costmaps.cost(value)))


def test_cells_with_full_keepout_value_are_occupied():
    info = GridInfo(0.1, 4, 1)
    grid = GridMap(np.array([[0, -1, 100, 0]], np.int8), info)
    zones = GridMap(np.array([[100, 100, 0, 99]], np.int8), info)
    assert barred(grid, zones).data.tolist() == [[100, 100, 100, 0]]
    assert grid.data.tolist() == [[0, -1, 100, 0]]
