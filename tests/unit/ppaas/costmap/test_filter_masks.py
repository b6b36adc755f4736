"""Masks of costmap filters, on the cells of a map and for the heights of a robot in a map in space."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap import filter_masks
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.filter_masks import barred, height_mask, raise_costs, sampled, spread
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.octomap import parse_octomap
from ppaas.maps.octree import OcTree, octree_of
from ppaas.maps.voxels import Point3D, VoxelGrid, VoxelInfo
from tests.reference.maps import costmaps
from tests.reference.maps import costmaps as twin
from tests.support.sources import ROOT


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


TABLE = parse_octomap((ROOT / "docs" / "examples" / "table.bt").read_bytes())
ROOM = GridInfo(0.05, 84, 64, Pose2D(-0.1, -0.1))


@st.composite
def trees(draw):
    """Draw voxels that include large cubes, and their octree."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    data = rng.choice(np.array([0, 255, 100], np.uint8), (6, 10, 9), p=[0.5, 0.2, 0.3])
    data[2:4, 2:8, 2:6] = draw(st.sampled_from([0, 100]))
    edge = draw(st.sampled_from([0.05, 0.1, 0.3]))
    begin = rng.integers(-9, 9, 3)
    voxels = VoxelGrid(data, VoxelInfo(edge, 9, 10, 6, Point3D(*(begin * edge).tolist())))
    return voxels, octree_of(voxels)


@given(
    trees(),
    st.sampled_from([0.05, 0.11, 0.2, 0.65]),
    st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.sampled_from([0.0, 0.7])),
    st.tuples(st.integers(-20, 20), st.integers(1, 30)),
)
def test_height_mask_agrees_with_the_twin(drawn, resolution, origin, heights):
    voxels, tree = drawn
    info = GridInfo(resolution, 12, 9, Pose2D(*origin))
    edge = tree.resolution
    lowest = heights[0] * edge / 2
    highest = lowest + heights[1] * edge / 2
    found = height_mask(tree, info, lowest=lowest, highest=highest)
    assert np.array_equal(found.data, twin.height_mask(voxels, found.info, lowest, highest))
    corners = info.origin @ Pose2D(12 * resolution, 0.0), info.origin @ Pose2D(0.0, 9 * resolution)
    assert all(found.info.cell_of(x, y) for x, y in (0.999 * np.array(corners)[:, :2] + 0.001 * np.array(origin[:2])))
    assert found.info.resolution == edge or edge < found.info.resolution <= resolution * (1.0 + 1e-6)


def test_table_top_blocks_a_mast_and_table_legs_block_all():
    low, tall = (height_mask(TABLE, ROOM, lowest=None, highest=height) for height in (0.42, 1.2))
    under = low.info.cell_of(2.0, 1.5)
    assert (low.data[under], tall.data[under]) == (0, 100)
    middle = (slice(2, -2), slice(2, -2))  # without the walls of the room
    assert (low.data[middle] == 100).sum() == 4
    assert (tall.data[middle] == 100).sum() == 160


@pytest.mark.parametrize(
    ("lowest", "highest", "hit"),
    [(None, 0.7, False), (None, 0.71, True), (0.8, 2.0, False), (0.79, 2.0, True), (0.75, 0.76, True)],
)
def test_touching_voxels_do_not_block(lowest, highest, hit):
    found = height_mask(TABLE, ROOM, lowest=lowest, highest=highest)
    assert (found.data[found.info.cell_of(2.0, 1.5)] == 100) == hit


def test_floor_and_lowest_voxels_are_ignored_by_default():
    data = np.zeros((3, 10, 10), np.uint8)
    data[0] = 100
    data[1, :, 5] = 100
    tree = octree_of(VoxelGrid(data, VoxelInfo(0.1, 10, 10, 3, Point3D(0.0, 0.0, -0.1))))
    info = GridInfo(0.1, 10, 10)
    assert not height_mask(tree, info, lowest=None, highest=1.0).data.any()
    step = height_mask(tree, info, lowest=0.0, highest=1.0).data
    assert (step[:, 5] == 100).all()
    assert (np.delete(step, 5, axis=1) == 0).all()


def test_empty_or_distant_octree_blocks_nothing():
    empty = OcTree(0.1, np.empty((0, 3), np.uint16), np.empty(0, np.uint8), np.empty(0, np.bool_))
    assert not height_mask(empty, ROOM, lowest=None, highest=1.0).data.any()
    away = GridInfo(0.05, 20, 20, Pose2D(-5000.0, 9000.0))
    assert not height_mask(TABLE, away, lowest=None, highest=1.0).data.any()


@pytest.mark.parametrize("resolution", [1e-300, 1e-6, 1e6, 1e300])
def test_extreme_resolution_gives_a_bounded_mask(resolution):
    tree = replace(TABLE, resolution=resolution)
    found = height_mask(tree, ROOM, lowest=None, highest=1.0)
    assert found.data.size <= 4 * ROOM.width * ROOM.height
    grid = GridMap(np.zeros(ROOM.shape, np.int8), ROOM)
    assert build_layers(grid, overhead=found).keepout.info == ROOM


def test_layers_combine_height_mask_and_keepout_mask():
    grid = GridMap(np.zeros(ROOM.shape, np.int8), ROOM)
    zones = GridMap(np.array([[0, 0], [0, 60]], np.int8), GridInfo(2.0, 2, 2))
    overhead = height_mask(TABLE, ROOM, lowest=None, highest=1.2)
    layers = build_layers(grid, keepout=zones, overhead=overhead)
    table, beside, mask = (ROOM.cell_of(*point) for point in ((2.0, 1.5), (2.0, 0.6), (3.5, 2.5)))
    assert [layers.keepout.data[cell] for cell in (table, beside, mask)] == [100, 0, 60]
    assert [layers.costmap.data[cell] for cell in (table, mask)] == [254, 152]
    assert 0.0 < layers.to_lethal[beside] < 0.6
    assert np.array_equal(layers.distance, build_layers(grid).distance)
