import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.costmap.collision import collides_along
from ppaas.costmap.volume import Cylinder
from ppaas.costmap.voxels import inflate_voxels
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    InvalidPlanner,
    NoValidPath,
    PlanCancelled,
    PlanTimeout,
    StartOccupied,
    StartOutsideMap,
)
from ppaas.geometry import Pose2D, yaw_of
from ppaas.maps.octomap import parse_octomap
from ppaas.maps.voxels import FREE, Point3D
from ppaas.planners import PlanRequest
from ppaas.planners.volume import PlanRequest3D, Pose3D, create, planner_names
from ppaas.planners.weights import RELATIVE_ERROR
from tests.reference.maps import costmaps
from tests.reference.planners import voxel_field
from tests.support.world import grids, voxels

ENCLOSED = np.zeros((60, 60, 60), np.uint8)
ENCLOSED[:2, :2, :2] = 254
ENCLOSED[0, 0, 0] = 0
"""A map without a path to (0, 0, 0), on which all other voxels are expanded."""


@pytest.fixture(params=["dijkstra3d", "astar3d"])
def name(request):
    """Return each of the planners: all tests run with each."""
    return request.param


@pytest.fixture
def plan(name):
    """Return a call that plans from voxel to voxel."""

    def planned(costs, start, goal, allow_unknown=True, **request):
        ends = voxels.place(costs, start), voxels.place(costs, goal)
        return create(name, allow_unknown=allow_unknown).plan(costs, PlanRequest3D(*ends, **request))

    return planned


def walkable(costs, cells, allow_unknown=True):
    """Return whether each move is one that the twin allows."""
    moves = itertools.pairwise(map(tuple, cells.tolist()))
    return all(there in dict(voxel_field.steps_from(costs, here, allow_unknown)) for here, there in moves)


@pytest.mark.parametrize("name", ["dijkstra3d", "astar3d"])
@given(costs=voxels.cost_arrays(), data=st.data(), allow_unknown=st.booleans())
def test_path_is_walkable_and_as_cheap_as_the_twins(name, costs, data, allow_unknown):
    free = voxels.free_voxels(costs, allow_unknown)
    assume(free)
    start, goal = data.draw(st.sampled_from(free)), data.draw(st.sampled_from(free))
    map_ = voxels.costmap(costs, 0.1)
    request = PlanRequest3D(voxels.place(map_, start), voxels.place(map_, goal))
    least = voxel_field.cost_field(costs, [goal], allow_unknown)[start]
    planner = create(name, allow_unknown=allow_unknown)
    if math.isinf(least):
        with pytest.raises(NoValidPath, match="no free path in space"):
            planner.plan(map_, request)
        return
    result = planner.plan(map_, request)
    assert walkable(costs, result.cells, allow_unknown)
    assert (tuple(result.cells[0]), tuple(result.cells[-1])) == (start, goal)
    assert least - 1e-9 <= result.cost <= least * (1 + 2 * RELATIVE_ERROR) + 1e-9


def test_poses_begin_and_end_at_the_requested_poses(name):
    map_ = voxels.costmap(np.zeros((4, 3, 5), np.uint8), 0.5, Point3D(1.0, 2.0, 3.0))
    start, goal = Pose3D(1.1, 2.2, 3.1, 2.0), Pose3D(3.4, 2.3, 4.6, -1.0)
    result = create(name).plan(map_, PlanRequest3D(start, goal))
    assert result.poses[0, :3].tolist() == [1.1, 2.2, 3.1]
    assert result.poses[-1, :3].tolist() == [3.4, 2.3, 4.6]
    assert yaw_of(*result.poses[0, 3:]) == pytest.approx(2.0)
    assert yaw_of(*result.poses[-1, 3:]) == pytest.approx(-1.0)
    assert result.cells[[0, -1]].tolist() == [[0, 0, 0], [3, 0, 4]]
    assert result.cells.dtype == np.int32
    assert result.cost == pytest.approx(50 * (1 + 3 * math.sqrt(2)))
    assert result.length == pytest.approx(np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum())
    assert (result.planner, result.to_message().poses is not None) == (name, True)


def test_heading_is_kept_while_rising(plan):
    shaft = np.full((6, 3, 3), 254, np.uint8)
    shaft[0, 1, :2] = shaft[:, 1, 1] = shaft[5, 2, 1] = 0
    result = plan(voxels.costmap(shaft), (0, 1, 0), (5, 2, 1))
    yaws = [yaw_of(*row[3:]) for row in result.poses]
    assert result.cells[:, 0].tolist() == [0, 0, 1, 2, 3, 4, 5, 5]
    assert yaws[1:6] == pytest.approx([0.0] * 5)
    assert yaws[6] == pytest.approx(math.pi / 2)


def test_start_equal_to_the_goal_gives_one_voxel_at_no_cost(plan):
    result = plan(voxels.costmap(np.zeros((1, 1, 1), np.uint8)), (0, 0, 0), (0, 0, 0))
    assert result.cells.tolist() == [[0, 0, 0]]
    assert (result.cost, result.length, len(result.poses)) == (0.0, 0.0, 1)


@pytest.mark.parametrize("shape", [(1, 1, 40_000), (1, 40_000, 1), (40_000, 1, 1)])
def test_shaft_one_voxel_wide_is_traversed(plan, shape):
    result = plan(voxels.costmap(np.full(shape, 252, np.uint8)), (0, 0, 0), tuple(size - 1 for size in shape))
    assert len(result.cells) == 40_000
    assert result.cost == pytest.approx(39_999 * 251.6)


def test_diagonal_move_past_an_obstacle_is_not_taken(plan):
    corner = np.zeros((2, 2, 2), np.uint8)
    corner[0, 1, 1] = 254
    assert len(plan(voxels.costmap(corner), (0, 0, 0), (1, 1, 1)).cells) > 2
    assert len(plan(voxels.costmap(np.zeros((2, 2, 2), np.uint8)), (0, 0, 0), (1, 1, 1)).cells) == 2


def test_path_with_few_turns_is_preferred_among_equal_costs(plan):
    moves = np.diff(plan(voxels.costmap(np.zeros((9, 12, 30), np.uint8)), (1, 1, 1), (4, 9, 27)).cells, axis=0)
    assert np.any(np.diff(moves, axis=0) != 0, axis=1).sum() == 2


def test_blocked_end_is_moved_to_the_nearest_free_place(plan):
    costs = np.zeros((5, 5, 9), np.uint8)
    costs[:, :, 6:] = 253
    map_ = voxels.costmap(costs, 0.1)
    result = plan(map_, (2, 2, 1), (2, 2, 8), tolerance=0.31)
    assert result.cells[-1].tolist() == [2, 2, 5]
    np.testing.assert_allclose(result.poses[-1, :3], map_.places((2, 2, 5)))
    assert plan(map_, (2, 2, 8), (2, 2, 1), tolerance=0.31).cells[0].tolist() == [2, 2, 5]
    with pytest.raises(GoalOccupied, match=r"x=0.850 y=0.250 z=0.200.*tolerance"):
        plan(map_, (2, 2, 1), (2, 2, 8), tolerance=0.29)
    with pytest.raises(StartOccupied, match="another start"):
        plan(map_, (2, 2, 8), (2, 2, 1))


@pytest.mark.parametrize(
    ("start", "goal", "error", "text"),
    [
        (Pose3D(-1.0, 0.5, 0.1), Pose3D(0.5, 0.5, 0.1), StartOutsideMap, "x=-1.000 y=0.500 z=0.100"),
        (Pose3D(0.5, 0.5, 0.1), Pose3D(0.5, 0.5, 1e300), GoalOutsideMap, "to x=3.000 y=1.000 z=1.000"),
        (Pose3D(0.5, 0.5, -0.6), Pose3D(0.5, 0.5, 0.0), StartOutsideMap, "z=-0.600"),
        (Pose3D(1.5, 0.5, 0.1), Pose3D(0.5, 0.5, 0.1), StartOccupied, "x=1.500"),
        (Pose3D(0.5, 0.5, 0.1), Pose3D(1.5, 0.5, 0.1), GoalOccupied, "x=1.500"),
        (Pose3D(0.5, 0.5, 0.1), Pose3D(2.5, 0.5, 0.1), NoValidPath, "2.5"),
        (Pose3D(math.nan, 0.5, 0.1), Pose3D(2.5, 0.5, 0.1), InvalidInput, "start"),
        (Pose3D(0.5, 0.5, 0.1), Pose3D(0.5, 0.5, math.nan), InvalidInput, "goal"),
    ],
)
def test_each_failure_has_its_error_type_and_position(name, start, goal, error, text):
    with pytest.raises(error, match=text):
        create(name).plan(voxels.costmap(np.array([[[0, 254, 0]]], np.uint8)), PlanRequest3D(start, goal))


@pytest.mark.parametrize("wrong", [{"tolerance": -0.1}, {"timeout": math.nan}, {"threads": 0}])
def test_an_invalid_request_is_refused(plan, wrong):
    with pytest.raises(InvalidInput):
        plan(voxels.costmap(np.zeros((1, 1, 2), np.uint8)), (0, 0, 0), (0, 0, 1), **wrong)


def test_2d_map_or_request_is_refused_with_advice(name):
    flat, ends = grids.costmap(".."), (Pose3D(0.5, 0.5, 0.0), Pose3D(1.5, 0.5, 0.0))
    with pytest.raises(InvalidPlanner, match="inflate_voxels"):
        create(name).plan(flat, PlanRequest3D(*ends))
    with pytest.raises(InvalidPlanner, match="PlanRequest3D, not VoxelCostmap and PlanRequest"):
        in_plane = PlanRequest(Pose2D(0.5, 0.5), Pose2D(1.5, 0.5))
        create(name).plan(voxels.costmap(np.zeros((1, 1, 2), np.uint8)), in_plane)


@pytest.mark.parametrize("checks", [0, 1, 5, 15])
def test_cancelled_plan_ends_at_the_next_check(plan, checks):
    count = 0

    def cancelled():
        nonlocal count
        count += 1
        return count > checks

    with pytest.raises(PlanCancelled):
        plan(voxels.costmap(ENCLOSED), (0, 0, 0), (59, 59, 59), cancelled=cancelled)
    assert count == checks + 1


def test_deadline_ends_the_plan(plan):
    clock = ManualClock()

    def tick():
        clock.advance(0.01)
        return False

    with pytest.raises(PlanTimeout, match=r"0\.05 s"):
        plan(voxels.costmap(ENCLOSED), (0, 0, 0), (59, 59, 59), timeout=0.05, clock=clock, cancelled=tick)


def test_ground_robot_climbs_stairs_up_to_its_step_height(name):
    stairs = voxels.room(6.0, 2.0, 3.0)
    for step in range(1, 6):
        voxels.put(stairs, (1.5 + 0.5 * step, 0.0, 0.0), (6.0, 2.0, 0.2 * step))
    low, high = Pose3D(0.75, 1.05, 0.0), Pose3D(5.25, 1.05, 1.0)
    robot = Cylinder(0.2, 0.5)
    climbing = inflate_voxels(stairs, robot, ground=True, max_step=0.2)
    up = create(name).plan(climbing, PlanRequest3D(low, high))
    down = create(name).plan(climbing, PlanRequest3D(high, low))
    assert up.cost == pytest.approx(down.cost)
    assert np.all(np.diff(up.poses[:, 2]) >= -1e-9)
    assert collides_along(stairs, robot, up.poses) is None
    for layer, row, column in up.cells.tolist():
        assert costmaps.stands(stairs.data, layer, row, column, 0.1, 0.2)
    with pytest.raises(NoValidPath, match="higher step"):
        create(name).plan(inflate_voxels(stairs, robot, ground=True, max_step=0.1), PlanRequest3D(low, high))
    flight = create(name).plan(inflate_voxels(stairs, robot), PlanRequest3D(low, high))
    assert flight.cost == pytest.approx(up.cost)


def test_low_robot_passes_under_a_table_and_a_tall_one_around_it(name):
    scene = voxels.room()
    voxels.put(scene, (1.5, 0.7, 0.7), (2.5, 2.3, 0.8))
    ends = PlanRequest3D(Pose3D(0.55, 1.55, 0.0), Pose3D(3.45, 1.55, 0.0))
    low, tall = (
        create(name, allow_unknown=False).plan(inflate_voxels(scene, volume, ground=True), ends)
        for volume in (Cylinder(0.18, 0.42), Cylinder(0.18, 1.2))
    )
    assert low.length == pytest.approx(2.9)
    assert tall.length > 3.2
    assert collides_along(scene, Cylinder(0.18, 1.2), low.poses) is not None
    assert collides_along(scene, Cylinder(0.18, 1.2), tall.poses) is None


def test_path_keeps_clear_of_walls_if_possible(plan):
    scene = voxels.room()
    graded = inflate_voxels(scene, Cylinder(0.1, 0.5), inflation_radius=1.0, cost_scaling_factor=1.0)
    result = plan(graded, graded.nearest((0.35, 0.25, 0.1)), graded.nearest((3.65, 0.25, 0.1)))
    assert result.poses[:, 1].max() > 0.6


@pytest.fixture(scope="module")
def building(data):
    """Return a floor of a building that a robot scanned."""
    return parse_octomap((data / "octomap" / "geb079.bt").read_bytes()).voxels()


def touched(scene, pose, radius, height):
    """Return whether an upright cylinder overlaps a voxel that is not free, checked voxel by voxel."""
    edge = scene.info.resolution
    middle, reach = scene.info.to_voxels(pose), np.array([math.ceil(height / edge), 4, 4])
    low, high = np.maximum(0, middle - reach), np.minimum(scene.info.shape, middle + reach + 1)
    near = np.argwhere(scene.data[tuple(map(slice, low, high))] != FREE) + low
    gaps = np.maximum(np.abs(scene.info.to_world(near) - pose - (0.0, 0.0, height / 2.0)) - edge / 2.0, 0.0)
    return bool(((np.hypot(gaps[:, 0], gaps[:, 1]) < radius - 1e-9) & (gaps[:, 2] < height / 2.0 - 1e-9)).any())


@pytest.mark.parametrize("ground", [True, False])
def test_path_through_a_scanned_building_has_no_collision(name, building, ground):
    robot = Cylinder(0.18, 0.42)
    costs = inflate_voxels(building, robot, ground=ground, max_step=0.16)
    start, goal = (Pose3D(-5.96, -1.08, 0.08), Pose3D(27.64, -1.08, 0.08))
    result = create(name, allow_unknown=False).plan(costs, PlanRequest3D(start, goal, tolerance=1.5))
    assert result.length > 33.0
    assert collides_along(building, robot, result.poses, allow_unknown=False) is None
    points = result.poses[:, :3]
    assert not any(touched(building, pose, 0.18, 0.42) for pose in (*points, *(points[1:] + points[:-1]) / 2.0))
    assert touched(building, points[9] + (0.0, 0.0, -0.3 if ground else 2.0), 0.18, 0.42)


def test_3d_planners_state_their_name_and_purpose():
    assert planner_names() == ("astar3d", "dijkstra3d")
    for name in planner_names():
        assert create(name).name == name
        assert create(name).purpose
