import numpy as np
import pytest

from benchmarks.people.runs.scene import GAP, hang_mirrors
from ppaas.geometry import Pose2D
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room


def test_mirrors_hang_on_straight_walls_and_face_the_room() -> None:
    grid = room(5.0, 4.0, origin=Pose2D(1.0, -2.0, 0.3))
    world = World(grid)
    assert hang_mirrors(world, ShortestPaths(grid, 0.35, np.random.default_rng(1)), 4) == 4
    for piece in world.furniture:
        x, y, theta = grid.info.origin.inverse() @ piece.pose
        wall = {0: x - 0.05, 1: y - 0.05, 2: 4.95 - x, 3: 3.95 - y}[round(theta / (0.5 * np.pi)) % 4]
        assert wall == pytest.approx(GAP, abs=1e-3)
        assert min(x, 5.0 - x) + min(y, 4.0 - y) >= 0.6


def test_no_mirror_hangs_where_no_wall_is_near() -> None:
    grid = room(30.0, 30.0)
    world = World(grid)
    middle = ShortestPaths(grid, 10.0, np.random.default_rng(1))
    assert hang_mirrors(world, middle, 1) == 0
    assert world.furniture == []
