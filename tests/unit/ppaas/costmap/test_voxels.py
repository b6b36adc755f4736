import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.volume import Box, Cylinder
from ppaas.costmap.voxels import MOST_REACH, VoxelCostmap, inflate_voxels
from ppaas.errors import InvalidMap, InvalidParameter
from ppaas.maps.voxels import FREE, OCCUPIED, Point3D, VoxelInfo
from tests.reference.maps import costmaps
from tests.support.world import voxels

SIZES = st.sampled_from([0.0, 0.05, 0.1, 0.17, 0.2, 0.25])


@given(voxels.grid_arrays(5), SIZES, st.sampled_from([0.01, 0.1, 0.15, 0.3, 9.0]), SIZES, st.sampled_from([0.0, 3.0]))
def test_costs_of_places_agree_with_the_twin(data, radius, height, inflation, factor):
    costs = inflate_voxels(
        voxels.grid(data, 0.1), Cylinder(radius, height), inflation_radius=inflation, cost_scaling_factor=factor
    )
    expected = costmaps.inflated(data, 0.1, radius, min(height, 0.7), inflation, factor)
    assert costs.data.tolist() == expected.tolist()


@given(voxels.grid_arrays(), st.sampled_from([0.0, 0.09, 0.1, 0.25]))
def test_ground_robot_needs_support_within_a_step(data, max_step):
    point = Cylinder(0.0, 0.05)
    flying = inflate_voxels(voxels.grid(data, 0.1), point).data
    standing = inflate_voxels(voxels.grid(data, 0.1), point, ground=True, max_step=max_step).data
    for voxel in np.ndindex(data.shape):
        held = costmaps.stands(data, *voxel, 0.1, max_step) or flying[voxel] == 254
        assert standing[voxel] == (flying[voxel] if held else 253)


@given(voxels.grid_arrays(5), SIZES, st.sampled_from([0.05, 0.1, 0.25]), st.data())
def test_robot_touches_nothing_between_free_places(data, radius, height, draw):
    volume = Cylinder(radius, height)
    costs = inflate_voxels(voxels.grid(data, 0.1), volume)
    free = voxels.free_voxels(costs.data, allow_unknown=True)
    if not free:
        return
    here = draw.draw(st.sampled_from(free))
    for move in itertools.product((-1, 0, 1), repeat=3):
        cube = set(itertools.product(*({at, at + step} for at, step in zip(here, move, strict=True))))
        if not cube <= set(free):
            continue
        there = np.add(here, move)
        for part in (0.0, 0.2, 0.5, 0.7):
            x, y, z = (1 - part) * costs.places(here) + part * costs.places(there)
            assert not costmaps.hits(
                data, 0.1, Cylinder(max(0.0, radius - 1e-9), height - 1e-9), (x, y, z + 5e-10, 0.0)
            )


def test_box_is_inflated_like_its_swept_cylinder():
    scene = voxels.room()
    voxels.put(scene, (2.0, 1.0, 0.0), (2.5, 1.5, 1.0))
    box = inflate_voxels(scene, Box(0.3, 0.4, 0.5))
    assert np.array_equal(box.data, inflate_voxels(scene, Cylinder(0.25, 0.5)).data)


def test_place_is_the_centre_of_the_voxels_floor():
    costs = voxels.costmap(np.zeros((2, 3, 4), np.uint8), 0.5, Point3D(1.0, 2.0, 3.0))
    np.testing.assert_allclose(costs.places((1, 0, 2)), (2.25, 2.25, 3.5))
    every = np.argwhere(costs.data == 0)
    assert np.array_equal(costs.nearest(costs.places(every)), every)
    assert costs.nearest((2.25, 2.25, 3.26)).tolist() == [1, 0, 2]
    assert costs.nearest((2.25, 2.25, 3.24)).tolist() == [0, 0, 2]


def test_space_beside_the_map_is_unknown():
    costs = inflate_voxels(voxels.grid(np.zeros((9, 9, 9), np.uint8), 0.1), Cylinder(0.2, 0.3)).data
    assert (costs[4] == 255).tolist() == [[not (2 <= r < 7 and 2 <= c < 7) for c in range(9)] for r in range(9)]
    assert costs[:, 4, 4].tolist() == [0] * 7 + [255] * 2


def test_a_single_voxel_is_inflated():
    for value, cost in ((FREE, 255), (OCCUPIED, 254)):
        grid = voxels.grid(np.full((1, 1, 1), value, np.uint8), 0.1)
        assert inflate_voxels(grid, Cylinder(5.0, 5.0)).data.tolist() == [[[cost]]]


@pytest.mark.parametrize("name", ["max_step", "inflation_radius", "cost_scaling_factor"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_parameters_out_of_range_are_refused_by_name(name, value):
    with pytest.raises(InvalidParameter, match=name):
        inflate_voxels(voxels.room(), Cylinder(0.2, 1.0), **{name: value})


def test_a_robot_too_large_for_the_voxels_is_refused():
    with pytest.raises(InvalidParameter, match="coarser depth"):
        inflate_voxels(voxels.room(), Cylinder(0.1 * MOST_REACH + 0.2, 1.0))


@pytest.mark.parametrize("data", [np.zeros((1, 1, 2), np.uint8), np.zeros((1, 1, 1), np.int8)])
def test_costs_of_another_shape_or_type_are_refused(data):
    with pytest.raises(InvalidMap):
        VoxelCostmap(data, VoxelInfo(0.1, 1, 1, 1))
