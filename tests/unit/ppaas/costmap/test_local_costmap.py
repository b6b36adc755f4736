"""The local costmap."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.social_layer import PersonNearby
from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.raycast import cast_rays
from tests.reference.maps import maps as twin
from tests.support.world import grids
from tests.support.world.maps import grid_of, poses, real_map

BEAMS = np.linspace(-math.pi, math.pi, 180, endpoint=False)


def empty(metres: float = 10.0, origin: Pose2D = Pose2D(0.0, 0.0)) -> MapLayers:
    """Return the layers of a map without obstacles, with cells of 0.1 m."""
    cells = round(metres * 10)
    return build_layers(grid_of(np.zeros((cells, cells), np.uint8), 0.1, origin))


def hit_at(pose: Pose2D, distance: float) -> LaserReading:
    """Return a reading of one beam straight ahead."""
    return LaserReading(pose, np.zeros(1), np.array([distance]))


def cost_at(costmap: Costmap, x: float, y: float) -> int:
    cell = costmap.info.cell_of(x, y)
    assert cell is not None
    return int(costmap.data[cell])


@given(
    st.integers(0, 2**32 - 1),
    poses(3.0),
    st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 0.4)), max_size=3),
)
def test_costs_are_those_of_all_obstacles_together(seed, robot, discs):
    """Costs are those of the map's obstacles, also outside the window, and of obstacles of this update."""
    rng = np.random.default_rng(seed)
    data = rng.choice(np.array([-1, 0, 100], np.int8), size=(30, 24), p=[0.1, 0.87, 0.03])
    grid = GridMap(data, GridInfo(0.1, 24, 30, Pose2D(-1.0, -1.0)))
    local = LocalCostmap(build_layers(grid), width=1.6, height=1.2)
    costmap = local.update(robot, None, discs)

    row, column = grid.info.to_cells((robot.x, robot.y)).tolist()
    row, column = row - 6, column - 8
    padded = np.full((200, 200), -1, np.int8)
    padded[80:110, 80:104] = data
    window = (slice(row + 80, row + 92), slice(column + 80, column + 96))
    lethal = (padded == 100).astype(np.uint8)
    for x, y, radius in discs:
        for cell in np.ndindex(12, 16):
            cx, cy = grid.info.to_world((cell[0] + row, cell[1] + column)).tolist()
            own = tuple(grid.info.to_cells((x, y)).tolist()) == (cell[0] + row, cell[1] + column)
            if own or math.hypot(cx - x, cy - y) <= radius:
                lethal[cell[0] + row + 80, cell[1] + column + 80] = 1
    near = 60  # cells that can matter, with a margin on all sides
    part = lethal[max(row + 80 - near, 0) : row + 92 + near, max(column + 80 - near, 0) : column + 96 + near]
    top, left = min(row + 80, near), min(column + 80, near)
    points = np.argwhere(part)
    for cell in np.ndindex(12, 16):
        outside = padded[window][cell] == -1
        away = np.hypot(*(points - (cell[0] + top, cell[1] + left)).T).min(initial=999.0) * 0.1
        robot_there = math.hypot(*(grid.info.to_world((cell[0] + row, cell[1] + column)) - robot[:2])) <= 0.3
        if robot_there or (outside and away < 0.25):
            continue
        exact = twin.cost(away, bool(outside), 0.18, 0.55, 10.0)
        assert costmap.data[cell] <= exact < costmap.data[cell] + 1.01


@given(poses(20.0), poses(5.0))
def test_the_window_is_centred_on_the_robot_and_aligned_to_the_map(robot, origin):
    layers = empty(2.0, origin)
    info = LocalCostmap(layers, width=3.0, height=2.0).update(robot).info
    assert (info.height, info.width, info.resolution) == (20, 30, 0.1)
    row, column = info.to_cells((robot.x, robot.y)).tolist()
    assert abs(row - 10) <= 1
    assert abs(column - 15) <= 1
    corner = layers.grid.info.origin.inverse() @ info.origin
    assert math.isclose(corner.x / 0.1, round(corner.x / 0.1), abs_tol=1e-6)
    assert math.isclose(corner.y / 0.1, round(corner.y / 0.1), abs_tol=1e-6)
    assert info.origin.theta == origin.theta


def test_laser_hit_is_lethal_and_inflated():
    robot = Pose2D(5.0, 5.0, math.pi / 2)
    costmap = LocalCostmap(empty()).update(robot, hit_at(robot, 1.02))
    assert cost_at(costmap, 5.0, 6.05) == 254
    assert cost_at(costmap, 5.0, 5.95) == 253
    assert 0 < cost_at(costmap, 5.0, 5.65) < 253
    assert cost_at(costmap, 5.0, 5.45) == 0


def test_laser_sees_what_is_not_on_the_map_within_a_disc():
    data = np.zeros((100, 100), np.uint8)
    data[:, 30] = 1
    local, robot = LocalCostmap(build_layers(grid_of(data, 0.1))), Pose2D(5.05, 5.05)
    assert not local.sees_at(6.05, 5.05, 1.0)
    local.update(robot, hit_at(robot, 1.02))
    assert local.sees_at(6.3, 5.05, 0.3) and not local.sees_at(6.4, 5.05, 0.3)
    wall = Pose2D(5.05, 5.05, math.pi)
    local.update(wall, hit_at(wall, 2.0))
    assert not local.sees_at(3.3, 5.05, 0.4), "a wall of the map is not what stands in front of it"


def test_laser_hit_is_placed_right_on_a_turned_map():
    layers = empty(10.0, Pose2D(3.0, -2.0, 0.7))
    robot = layers.grid.info.origin @ Pose2D(5.0, 5.0, -0.3)
    costmap = LocalCostmap(layers).update(robot, hit_at(robot, 1.5))
    hit = robot @ Pose2D(1.505, 0.0)
    assert cost_at(costmap, hit.x, hit.y) == 254
    assert (costmap.data == 254).sum() == 1


def test_hit_persists_until_a_later_beam_clears_it():
    local, robot = LocalCostmap(empty()), Pose2D(5.0, 5.0)
    local.update(robot, hit_at(robot, 1.02))
    moved = Pose2D(4.5, 5.0)
    assert cost_at(local.update(moved), 6.05, 5.05) == 254
    assert cost_at(local.update(moved, hit_at(moved, math.inf)), 6.05, 5.05) == 0


def test_a_hit_that_left_the_window_is_forgotten():
    local, robot = LocalCostmap(empty()), Pose2D(5.0, 5.0)
    local.update(robot, hit_at(robot, 1.02))
    local.update(Pose2D(1.0, 5.0))
    assert cost_at(local.update(robot), 6.05, 5.05) == 0


def test_free_removes_hits_within_the_disc_only():
    local, robot = LocalCostmap(empty(origin=Pose2D(1.0, -2.0, 0.5))), Pose2D(3.0, 3.0, 0.5)
    ahead, beside = robot @ Pose2D(1.5, 0.0), robot @ Pose2D(1.5, 0.0, 1.0) @ Pose2D(1.0, 0.0)
    for there in (ahead, beside):
        bearing = math.atan2(there.y - robot.y, there.x - robot.x)
        local.update(robot, hit_at(Pose2D(robot.x, robot.y, bearing), robot.distance_to(there)))
    local.free([(ahead.x, ahead.y, 0.3)])
    costmap = local.update(robot)
    assert cost_at(costmap, ahead.x, ahead.y) < LETHAL_OBSTACLE
    assert cost_at(costmap, beside.x, beside.y) == LETHAL_OBSTACLE


def test_discs_of_people_and_robots_last_one_update():
    local, robot = LocalCostmap(empty()), Pose2D(5.0, 5.0)
    assert cost_at(local.update(robot, None, [(6.0, 6.0, 0.3)]), 6.05, 6.05) == 254
    assert (local.update(robot).data == 0).all()


def test_cells_beyond_the_map_are_unknown_until_seen():
    local, robot = LocalCostmap(empty()), Pose2D(9.0, 5.05)
    before = local.update(robot)
    assert cost_at(before, 9.95, 5.05) == 0
    assert cost_at(before, 10.55, 5.05) == 255
    after = local.update(robot, hit_at(robot, math.inf))
    assert cost_at(after, 10.55, 5.05) == 0
    assert cost_at(after, 10.55, 5.25) == 255


def test_window_outside_the_map_is_unknown():
    assert (LocalCostmap(empty()).update(Pose2D(-500.0, 1e7)).data[:5] == 255).all()


def test_an_obstacle_of_the_map_just_outside_the_window_is_inflated_into_it():
    occupied = np.zeros((100, 100), np.uint8)
    occupied[50, 62] = 1
    local = LocalCostmap(build_layers(grid_of(occupied, 0.1)), width=2.0, height=2.0)
    costmap = local.update(Pose2D(5.25, 5.05))
    assert (costmap.data < 254).all()
    assert costmap.data[10, -1] == 253


def test_masks_apply_in_the_window_as_on_the_map():
    """Keep-out zones count, also outside the window, whatever the laser sees in them."""
    zones = np.zeros((100, 100), np.int8)
    zones[20:50, 62:], zones[60:70, 40:50], zones[20:80, 38:40] = 100, 30, 100
    grid = grid_of(np.zeros((100, 100), np.uint8), 0.1)
    layers = build_layers(grid, keepout=GridMap(zones, grid.info))
    local, robot = LocalCostmap(layers, width=2.0, height=3.0), Pose2D(5.05, 5.05)
    seen = local.update(robot, LaserReading(robot, BEAMS, np.full(len(BEAMS), math.inf)))
    assert np.array_equal(seen.data, layers.costmap.data[35:65, 40:60])
    assert {0, 76, 253} <= set(seen.data.ravel().tolist())
    local.clear()
    assert local.overlay(layers.costmap) is layers.costmap


def test_mask_gives_unknown_cells_a_cost():
    grid = GridMap(np.full((60, 60), -1, np.int8), GridInfo(0.1, 60, 60))
    zones = np.zeros((60, 60), np.int8)
    zones[:, 40:] = 50
    layers = build_layers(grid, keepout=GridMap(zones, grid.info))
    seen = LocalCostmap(layers, width=4.0, height=4.0).update(Pose2D(3.0, 3.0))
    assert cost_at(seen, 4.55, 3.05) == 127
    assert cost_at(seen, 3.55, 3.05) == 255


def test_costmap_without_the_static_layer_has_seen_obstacles_only():
    occupied = np.ones((50, 50), np.uint8)
    robot = Pose2D(4.0, 2.5)
    local = LocalCostmap(build_layers(grid_of(occupied, 0.1)), static=False)
    assert (local.update(robot).data == 0).all()
    assert (local.update(robot, hit_at(robot, 1.0)).data == 254).sum() == 1


def test_hits_within_the_robot_are_ignored():
    robot = Pose2D(5.0, 5.0)
    assert (LocalCostmap(empty()).update(robot, hit_at(robot, 0.1)).data == 0).all()


def test_each_update_returns_its_own_copy():
    local, robot = LocalCostmap(empty()), Pose2D(5.0, 5.0)
    first = local.update(robot)
    local.update(robot, hit_at(robot, 1.0))
    assert (first.data == 0).all()


def test_clearing_forgets_the_hits():
    local, robot = LocalCostmap(empty()), Pose2D(5.0, 5.0)
    local.update(robot, hit_at(robot, 1.0))
    local.clear()
    assert local.overlay(empty().costmap).data.max() == 0
    assert (local.update(robot).data == 0).all()


@pytest.mark.parametrize("origin", [Pose2D(0.0, 0.0), Pose2D(3.0, -2.0, 0.7)])
def test_clearing_around_a_pose_removes_only_hits_farther_away(origin):
    layers = empty(origin=origin)
    local, robot = LocalCostmap(layers), origin @ Pose2D(5.0, 5.0)
    local.update(robot, hit_at(robot, 1.02))
    local.clear(robot, 1.2)
    assert (local.update(robot).data == 254).any()
    assert local.overlay(layers.costmap).data.max() >= 253
    local.clear(robot, 0.9)
    assert local.overlay(layers.costmap) is layers.costmap
    assert (local.update(robot).data == 0).all()


# Overlaying the costmap of the whole map.


def test_overlay_raises_costs_in_the_window_without_changing_the_map():
    layers, robot = empty(), Pose2D(5.0, 5.0)
    layers.costmap.data.flags.writeable = False
    local = LocalCostmap(layers, width=4.0, height=3.0)
    window = local.update(robot, hit_at(robot, 1.02))
    over = local.overlay(layers.costmap)
    assert cost_at(over, 6.05, 5.05) == 254
    assert np.array_equal(over.data[35:65, 30:70], window.data)
    outside = over.data.copy()
    outside[35:65, 30:70] = 0
    assert not outside.any()
    assert not layers.costmap.data.any()


def test_overlay_without_new_obstacles_is_the_map_itself():
    layers = build_layers(warehouse(resolution=0.1))
    local, robot = LocalCostmap(layers), Pose2D(3.0, 3.0)
    local.update(robot)
    assert local.overlay(layers.costmap) is layers.costmap


def test_the_overlay_blocks_unknown_cells_but_does_not_open_them():
    grid = GridMap(np.full((100, 100), -1, np.int8), GridInfo(0.1, 100, 100))
    layers, robot = build_layers(grid), Pose2D(5.0, 5.0)
    local = LocalCostmap(layers)
    local.update(robot, hit_at(robot, 1.02))
    over = local.overlay(layers.costmap)
    assert cost_at(over, 6.05, 5.05) == 254
    assert cost_at(over, 5.95, 5.05) == 253
    assert cost_at(over, 5.45, 5.05) == 255


@pytest.mark.parametrize("x", [0.2, 0.9, 9.9, 12.5])
def test_overlay_accepts_windows_beyond_the_edge(x):
    layers, robot = empty(), Pose2D(x, 0.3, math.pi)
    local = LocalCostmap(layers)
    local.update(robot, None, [(x - 0.6, 0.5, 0.2)])
    over = local.overlay(layers.costmap)
    assert (over.data.max() == 254) == (0.0 <= x - 0.6 < 10.0)


@pytest.mark.parametrize("x", [0.2, 0.9, 5.0, 9.9])
def test_overlay_keeps_where_it_differs_from_the_map(x):
    layers, robot = empty(), Pose2D(x, 0.3, math.pi)
    static = layers.costmap.read_only()
    local = LocalCostmap(layers)
    local.update(robot, None, [(max(x - 0.6, 0.1), 0.5, 0.2)])
    over = local.overlay(static)
    assert over.data.max() == 254
    assert grids.keeps_its_changes(over, static)


def test_overlay_refuses_the_costmap_of_another_map():
    with pytest.raises(InvalidMap, match="different maps"):
        LocalCostmap(empty()).overlay(empty(5.0).costmap)


# Bad input.


@pytest.mark.parametrize("pose", [Pose2D(math.nan, 0.0), Pose2D(0.0, math.inf), Pose2D(0.0, 0.0, math.nan)])
def test_non_finite_pose_is_refused(pose):
    with pytest.raises(InvalidInput, match="pose"):
        LocalCostmap(empty()).update(pose)


@pytest.mark.parametrize("disc", [(math.nan, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, math.inf)])
def test_non_finite_obstacle_is_refused(disc):
    with pytest.raises(InvalidInput, match="obstacle"):
        LocalCostmap(empty()).update(Pose2D(5.0, 5.0), None, [disc])


@pytest.mark.parametrize(
    ("parameters", "named"),
    [
        ({"width": 0.0}, "width"),
        ({"height": math.nan}, "height"),
        ({"width": 1e6}, "cells"),
        ({"width": 1e300}, "cells"),
        ({"robot_radius": -0.1}, "inscribed_radius"),
        ({"inflation_radius": math.inf}, "inflation_radius"),
        ({"cost_scaling_factor": -1.0}, "cost_scaling_factor"),
        ({"obstacle_range": -1.0}, "obstacle_range"),
        ({"raytrace_range": math.nan}, "raytrace_range"),
    ],
)
def test_parameter_out_of_range_is_refused_by_name(parameters, named):
    with pytest.raises(InvalidParameter, match=named):
        LocalCostmap(empty(), **parameters)


# Real maps.


def test_perfect_laser_marks_only_cells_near_walls_of_a_real_map(data):
    grid = real_map(data, "tb3_sandbox")
    layers = build_layers(grid)
    local = LocalCostmap(layers)
    for step in range(10):
        robot = Pose2D(-2.0 + 0.05 * step, -0.5, 0.1 * step)
        ranges = cast_rays(layers.distance == 0, grid.info, robot, BEAMS, 3.5)
        costmap = local.update(robot, LaserReading(robot, BEAMS, ranges))
        rows, columns = np.nonzero(costmap.data == 254)
        cells = grid.info.to_cells(costmap.info.to_world(np.stack((rows, columns), axis=-1)))
        assert len(cells) > 100
        assert layers.distance[cells[:, 0], cells[:, 1]].max() < 0.08


def test_people_raise_costs_around_them_for_one_update():
    layers = empty()
    local = LocalCostmap(layers, width=4.0, height=4.0)
    robot, person = Pose2D(5.0, 5.0), PersonNearby(6.0, 5.0, 0.0, 1.0)
    costmap = local.update(robot, people=[person])
    assert cost_at(costmap, 6.0, 5.0) > 70
    assert cost_at(costmap, 6.0, 5.8) > cost_at(costmap, 6.0, 4.2)
    assert cost_at(costmap, 6.0, 4.2) == math.floor(77.0 * math.exp(-(0.05**2 + 0.75**2) / 0.5))
    assert cost_at(local.overlay(layers.costmap), 6.0, 5.8) == cost_at(costmap, 6.0, 5.8)
    assert not local.update(robot).data.any()
    assert local.overlay(layers.costmap) is layers.costmap


def test_plans_lead_around_the_space_between_people_who_talk():
    layers = empty()
    local = LocalCostmap(layers, width=4.0, height=4.0)
    costmap = local.update(Pose2D(5.0, 5.0), between=[PersonNearby(6.0, 5.0)])
    assert cost_at(costmap, 6.0, 5.0) >= 195
    assert cost_at(local.overlay(layers.costmap), 6.0, 5.0) >= 195
    local.update(Pose2D(5.0, 5.0))
    assert local.overlay(layers.costmap) is layers.costmap


def test_costs_of_people_are_placed_right_on_a_turned_map():
    turned = LocalCostmap(empty(origin=Pose2D(10.0, 0.0, math.pi / 2)), width=4.0, height=4.0)
    costmap = turned.update(Pose2D(5.0, 5.0), people=[PersonNearby(5.0, 5.0, 1.0, 0.0)])
    assert cost_at(costmap, 5.9, 5.05) > 2 * cost_at(costmap, 5.05, 5.7)


# -- another map -------------------------------------------------------------------------------------------------------


@given(*[st.integers(-15, 15)] * 2, *[st.integers(-30, 130)] * 2)
def test_costs_on_a_map_whose_corner_moved_are_those_of_a_window_that_was_always_there(row, column, y, x):
    robot = Pose2D(0.1 * x + 0.05, 0.1 * y + 0.05)  # the centre of a cell
    corner = Pose2D(-0.1 * column, -0.1 * row)
    before, after = empty(), empty(origin=corner)
    reading = hit_at(robot, 0.8)
    changed, fresh = LocalCostmap(before), LocalCostmap(after)
    changed.update(robot, reading)
    changed.use_layers(after)
    fresh.update(robot, reading)
    np.testing.assert_array_equal(changed.update(robot).data, fresh.update(robot).data)
    np.testing.assert_array_equal(changed.overlay(after.costmap).data, fresh.overlay(after.costmap).data)


@pytest.mark.parametrize("other", [GridInfo(0.1, 50, 50, Pose2D(0.0, 0.0, 0.3)), GridInfo(0.05, 200, 200)])
def test_the_window_is_empty_on_a_map_with_other_cells(other):
    local, robot = LocalCostmap(empty()), Pose2D(2.0, 2.0)
    local.update(robot, hit_at(robot, 0.8))
    layers = build_layers(GridMap(np.zeros(other.shape, np.int8), other))
    local.use_layers(layers)
    assert local.overlay(layers.costmap) is layers.costmap
    costmap = local.update(robot)
    assert (costmap.info.resolution, costmap.info.width) == (other.resolution, round(6.0 / other.resolution))
    assert not (costmap.data == LETHAL_OBSTACLE).any()
