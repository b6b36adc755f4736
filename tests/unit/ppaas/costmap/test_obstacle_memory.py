"""Memory of obstacles that have left the local costmap."""

import math

import numpy as np

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.obstacle_memory import ObstacleMemory
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from tests.support.world import grids
from tests.support.world.planar_world import World, fill, walled_map

GRID = walled_map(16, 8, [])
LAYERS = build_layers(GRID)
BOX = (4.0, 3.0, 4.3, 5.0)
NEAR, FAR = Pose2D(2.5, 4.0, 0.0), Pose2D(12.0, 4.0, 0.0)


class Walk:
    """A robot with a laser, in a world with a box that is not in the map."""

    def __init__(self) -> None:
        self.world = World(GRID, NEAR, beams=720, noise=0.0, range_max=20.0)
        cells = GRID.data.copy()
        fill(cells, GRID.info, BOX)
        self.world.truth[:] = cells >= 50
        self.local = LocalCostmap(LAYERS)
        self.memory = ObstacleMemory(LAYERS)

    def look(self, pose: Pose2D, others=()) -> None:
        self.world.pose = pose
        self.local.update(pose, LaserReading.of(self.world.scan(0.0), pose))
        self.memory.update(self.local.obstacles, others)

    def cost(self, x: float, y: float) -> int:
        cell = GRID.info.cell_of(x, y)
        assert cell is not None
        return int(self.memory.overlay(LAYERS.costmap).data[cell])


def test_an_obstacle_that_has_left_the_window_is_remembered():
    walk = Walk()
    walk.look(NEAR)
    assert walk.cost(4.02, 4.0) == 254
    walk.look(FAR)
    assert not walk.local.obstacles.marked[:, :10].any()
    assert walk.cost(4.02, 4.0) == 254
    assert walk.cost(3.9, 4.0) == 253
    assert 0 < walk.cost(3.7, 4.0) < 253


def test_overlay_changes_only_remembered_places():
    walk = Walk()
    assert walk.memory.overlay(LAYERS.costmap) is LAYERS.costmap
    walk.look(NEAR)
    overlaid = walk.memory.overlay(LAYERS.costmap)
    assert overlaid is not LAYERS.costmap
    np.testing.assert_array_equal(overlaid.data[:, 200:], LAYERS.costmap.data[:, 200:])
    assert (overlaid.data >= LAYERS.costmap.data).all()


def test_the_overlay_keeps_where_it_differs_from_the_map():
    walk, static = Walk(), LAYERS.costmap.read_only()
    walk.look(NEAR)
    walk.look(FAR)
    both = walk.memory.overlay(walk.local.overlay(static))
    assert (both.data != static.data).any()
    assert grids.keeps_its_changes(both, static)


def test_the_overlay_does_not_write_to_the_map():
    before = LAYERS.costmap.data.copy()
    walk = Walk()
    walk.look(NEAR)
    walk.memory.overlay(LAYERS.costmap)
    np.testing.assert_array_equal(LAYERS.costmap.data, before)


def test_obstacle_seen_free_again_is_forgotten():
    walk = Walk()
    walk.look(NEAR)
    walk.look(FAR)
    walk.world.truth[:] = GRID.data >= 50
    walk.look(NEAR)
    assert len(walk.memory.cells) == 0


def test_map_walls_seen_slightly_displaced_are_not_remembered():
    walk = Walk()
    walk.world.truth[:] = GRID.data >= 50
    corner = Pose2D(1.5, 1.5, 0.0)
    walk.world.pose = corner
    scan = walk.world.scan(0.0)
    off = corner @ Pose2D(0.08, -0.05, 0.0)
    walk.local.update(off, LaserReading.of(scan, off))
    walk.memory.update(walk.local.obstacles)
    assert walk.local.obstacles.marked.any()
    assert len(walk.memory.cells) == 0


def test_other_known_robots_are_not_remembered():
    walk = Walk()
    walk.look(NEAR, others=[(4.1, 4.0, 1.3)])
    assert len(walk.memory.cells) == 0


def test_clear_forgets_all_obstacles():
    walk = Walk()
    walk.look(NEAR)
    walk.memory.clear()
    assert walk.cost(4.02, 4.0) == 0


def test_clear_beyond_a_distance_keeps_near_obstacles():
    walk = Walk()
    walk.look(NEAR)
    walk.memory.clear(Pose2D(4.0, 3.0, 0.0), beyond=1.0)
    assert walk.cost(4.02, 3.2) == 254
    assert walk.cost(4.02, 4.8) < 253


def test_turned_map_remembers_obstacles_in_its_own_cells():
    turned = walled_map(16, 8, [])
    info = type(turned.info)(0.05, turned.info.width, turned.info.height, Pose2D(3.0, -2.0, math.pi / 3))
    layers = build_layers(type(turned)(turned.data, info))
    local, memory = LocalCostmap(layers), ObstacleMemory(layers)
    pose = info.origin @ NEAR
    reading = LaserReading(pose, np.array([0.0]), np.array([1.5]))
    local.update(pose, reading)
    memory.update(local.obstacles)
    ahead = pose @ Pose2D(1.5, 0.0, 0.0)
    ((row, column),) = memory.cells.tolist()
    assert (
        info.to_cells((ahead.x, ahead.y)).tolist() == [row, column]
        or math.dist(info.to_world((row, column)), (ahead.x, ahead.y)) < 0.05
    )


# -- another map -------------------------------------------------------------------------------------------------------


def test_obstacles_stay_in_place_on_a_map_whose_corner_is_elsewhere():
    walk = Walk()
    walk.look(NEAR)
    info, data = GRID.info, np.pad(GRID.data, 9, constant_values=-1)
    wide = GridInfo(info.resolution, data.shape[1], data.shape[0], info.origin @ Pose2D(-0.45, -0.45))
    before = set(map(tuple, info.to_world(walk.memory.cells).round(4).tolist()))
    walk.memory.use_layers(build_layers(GridMap(data, wide)))
    assert set(map(tuple, wide.to_world(walk.memory.cells).round(4).tolist())) == before


def test_obstacles_that_the_new_map_contains_or_does_not_cover_are_forgotten():
    walk = Walk()
    walk.look(NEAR)
    walk.memory.use_layers(build_layers(GridMap((walk.world.truth * 100).astype(np.int8), GRID.info)))
    assert not len(walk.memory.cells)
    walk = Walk()
    walk.look(NEAR)
    walk.memory.use_layers(build_layers(GridMap(GRID.data[:, :70].copy(), GridInfo(0.05, 70, GRID.info.height))))
    assert not len(walk.memory.cells)
    assert walk.memory.overlay(LAYERS.costmap) is LAYERS.costmap
