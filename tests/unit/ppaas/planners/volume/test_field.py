import itertools
import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra as scipy_dijkstra

from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput, NoValidPath
from ppaas.planners.volume import field as field_module
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.weights import RELATIVE_ERROR, SCALE
from tests.reference.planners import voxel_field as twin
from tests.support.sources import ROOT
from tests.support.world import voxels


@st.composite
def scenes(draw):
    costs = draw(voxels.cost_arrays())
    allow_unknown = draw(st.booleans())
    if not voxels.free_voxels(costs, allow_unknown):
        costs[0, 0, 0] = 0
    free = st.sampled_from(voxels.free_voxels(costs, allow_unknown))
    return costs, draw(st.lists(free, min_size=1, max_size=3)), allow_unknown


def grown(costs, goals, allow_unknown=True):
    field = VoxelField(voxels.costmap(costs), np.array(goals), allow_unknown=allow_unknown)
    assert field.grow()
    return field


def noise(seed, shape, blocked=0.2):
    rng = np.random.default_rng(seed)
    costs = rng.integers(0, 253, shape).astype(np.uint8)
    costs[rng.random(shape) < blocked] = 254
    costs[rng.random(shape) < 0.05] = 255
    return costs


@given(scenes())
def test_field_equals_the_fixed_point_twin(scene):
    values = grown(*scene).values() * SCALE
    assert np.array_equal(np.rint(values), twin.cost_field(*scene, units=SCALE))


@given(scenes())
def test_field_is_within_its_error_bound_of_the_float_twin(scene):
    values, exact = grown(*scene).values(), twin.cost_field(*scene)
    assert np.array_equal(np.isinf(values), np.isinf(exact))
    reached = ~np.isinf(exact)
    assert np.all(np.abs(values[reached] - exact[reached]) <= exact[reached] * RELATIVE_ERROR + 1e-9)


@pytest.mark.parametrize("seed", range(2))
def test_the_field_agrees_with_scipy_on_larger_grids(seed):
    costs = noise(seed, (9, 14, 17))
    goal = voxels.free_voxels(costs, True)[50]
    sources, targets, weights = zip(*twin.edges(costs), strict=True)
    graph = coo_array((weights, (sources, targets)), shape=(costs.size, costs.size)).tocsr()
    exact = scipy_dijkstra(graph, indices=int(np.ravel_multi_index(goal, costs.shape))).reshape(costs.shape)
    np.testing.assert_allclose(grown(costs, [goal]).values(), exact, rtol=RELATIVE_ERROR)


@given(scenes(), st.data())
def test_value_of_a_target_equals_that_of_the_whole_field(scene, data):
    costs, goals, allow_unknown = scene
    target = data.draw(st.sampled_from(voxels.free_voxels(costs, allow_unknown)))
    whole = grown(costs, goals[:1], allow_unknown).values()[target]
    field = VoxelField(voxels.costmap(costs), np.array(goals[:1]), target=target, allow_unknown=allow_unknown)
    assert field.grow() == math.isfinite(whole)
    if math.isfinite(whole):
        assert field.values()[target] == whole


def test_values_nearer_than_the_target_are_final():
    costs = noise(3, (30, 30, 30), blocked=0.3)
    few = voxels.free_voxels(costs, True)[::1_500]
    for start, goal in itertools.pairwise(few):
        whole = grown(costs, [goal]).values()
        field = VoxelField(voxels.costmap(costs), np.array([goal]), target=start)
        assert field.grow() == math.isfinite(whole[start])
        away = np.sort(np.abs(np.indices(costs.shape).reshape(3, -1).T - start), axis=1)
        remaining = (np.diff(away, axis=1, prepend=0) * (7361, 6010, 4250)).sum(axis=1).reshape(costs.shape) / SCALE
        nearer = whole + remaining < whole[start]
        assert np.array_equal(field.values()[nearer], whole[nearer])


def test_slices_of_any_size_give_the_same_field(monkeypatch):
    costs = noise(5, (20, 21, 22))
    goal = voxels.free_voxels(costs, True)[7]
    whole = grown(costs, [goal])
    monkeypatch.setattr(field_module, "SLICE_VOXELS", 1)
    monkeypatch.setattr(field_module, "SLICE_SETUP", 1)
    monkeypatch.setattr(field_module, "SLICE_WALKED", 1)
    sliced = grown(costs, [goal])
    assert np.array_equal(sliced.values(), whole.values())
    start = voxels.free_voxels(costs, True)[-9]
    assert np.array_equal(sliced.path_from(start), whole.path_from(start))


def test_each_reached_voxel_is_expanded_once():
    costs = noise(7, (25, 25, 25))
    field = grown(costs, [voxels.free_voxels(costs, True)[0]])
    assert field.settled == np.isfinite(field.values()).sum()


def test_full_pool_grows_without_losing_entries():
    costs = noise(8, (60, 60, 60), blocked=0.0)
    free = voxels.free_voxels(costs, True)
    one, many = grown(costs, free[:1]), grown(costs, free)
    assert len(one._queue.pool) > 2 * 58 + 1
    assert np.all(many.values()[costs < 253] == 0.0)
    sliced = VoxelField(voxels.costmap(costs), np.array(free[:1]))
    sliced.grow(free[0])
    assert sliced.grow()
    assert np.array_equal(sliced.values(), one.values())


def test_field_and_queue_use_at_most_eight_bytes_a_voxel():
    for costs in (np.zeros((90, 90, 90), np.uint8), noise(9, (90, 90, 90), blocked=0.0)):
        field = grown(costs, [(0, 0, 0)])
        taken = field._field.nbytes + field._costs.nbytes + field._queue.pool.nbytes + field._queue.links.nbytes
        assert taken <= 8 * costs.size


def test_early_stop_leaves_the_rest_unsettled_and_a_target_leaves_more():
    costs = np.zeros((50, 50, 50), np.uint8)
    outward = VoxelField(voxels.costmap(costs), np.array([(25, 25, 25)]))
    aimed = VoxelField(voxels.costmap(costs), np.array([(25, 25, 25)]), target=(25, 25, 35))
    assert outward.grow((25, 25, 35))
    assert aimed.grow()
    assert aimed.settled < 200 < outward.settled < 8_000
    for field in (outward, aimed):
        assert field.path_from((25, 25, 35)).tolist() == [[25, 25, c] for c in range(35, 24, -1)]


def test_a_path_too_long_for_the_field_is_refused():
    snake = np.full((1, 401, 1_001), 255, np.uint8)
    snake[0, 1::2] = 254
    snake[0, 1::4, -1] = 255
    snake[0, 3::4, 0] = 255
    assert 201 * 1_001 * 253 * SCALE > 2**32
    for target in (None, (0, 400, 1_000)):
        field = VoxelField(voxels.costmap(snake), np.array([(0, 0, 0)]), target=target)
        with pytest.raises(NoValidPath, match="coarser depth"):
            field.grow()


@pytest.mark.parametrize(
    ("goals", "error"),
    [
        (np.empty((0, 3), int), InvalidInput),
        (np.array([0, 0, 0]), InvalidInput),
        (np.array([[0, 0]]), InvalidInput),
        (np.array([[0, 0, 3]]), GoalOutsideMap),
        (np.array([[0, -1, 0]]), GoalOutsideMap),
        (np.array([[0, 0, 1]]), GoalOccupied),
        (np.array([[0, 0, 2]]), GoalOccupied),
    ],
)
def test_invalid_goals_are_refused(goals, error):
    with pytest.raises(error):
        VoxelField(voxels.costmap(np.array([[[0, 254, 255]]], np.uint8)), goals, allow_unknown=False)


def test_a_target_takes_one_goal():
    with pytest.raises(InvalidInput, match="one goal"):
        VoxelField(voxels.costmap(np.zeros((1, 1, 2), np.uint8)), np.zeros((2, 3), int), target=(0, 0, 1))


PROGRAM = """
import itertools
from pathlib import Path

from engine.runtimes.compilation.kernel_modules import record_compilations
from ppaas.costmap.collision import collides_along
from ppaas.costmap.kernels import collision, voxels
from ppaas.costmap.volume import Box, Cylinder
from ppaas.costmap.voxels import VoxelCostmap, inflate_voxels
from ppaas.maps.kernels import octree
from ppaas.maps.octomap import binary_octomap, parse_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import VoxelGrid
from ppaas.planners.volume import PlanRequest3D, Pose3D, create
from ppaas.planners.volume.kernels import descent, propagation, setup

for module in (collision, voxels, octree, descent, propagation, setup):
    module.warm()
recorder = record_compilations()
text = Path("docs/examples/table.bt").read_bytes()
scene = parse_octomap(binary_octomap(octree_of(parse_octomap(text).voxels()))).voxels()
for writeable, ground in itertools.product((True, False), repeat=2):
    scene.data.flags.writeable = writeable
    costmap = inflate_voxels(VoxelGrid(scene.data, scene.info), Box(0.3, 0.2, 0.4), ground=ground, max_step=0.1)
    costmap.data.flags.writeable = writeable
    for name in ("astar3d", "dijkstra3d"):
        path = create(name).plan(costmap, PlanRequest3D(Pose3D(0.5, 1.5, 0.0), Pose3D(3.5, 1.5, 0.0)))
        assert collides_along(scene, Cylinder(0.15, 0.4), path.poses) is None
print(len(recorder.buffer))
"""


def test_no_kernel_is_compiled_after_warm():
    command = [sys.executable, "-c", PROGRAM]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=120)
    assert (ended.stdout, ended.stderr) == ("0\n", "")
