"""Small worlds to drive in, drawn by a seed."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.field.cost_field import cost_field
from ppaas.planners.grid.dijkstra import Dijkstra
from tests.support.world.driving import World


def picture(text: str, scale: int = 8) -> World:
    """Return the world of a picture, the lowest row last; each ``#`` is a block of ``scale``² wall cells."""
    lines = [line.strip() for line in text.strip().splitlines()][::-1]
    blocks = np.array([[sign == "#" for sign in line] for line in lines])
    return World(np.kron(blocks, np.ones((scale, scale), bool)))


def rooms(seed: int) -> World:
    """Draw eight rooms with doors of 0.7 m; the robot is 0.36 m wide."""
    rng = np.random.default_rng(seed)
    walls = _walled(120, 160)
    for column in (40, 80, 120):
        walls[:, column : column + 2] = True
        door = rng.integers(4, 40) + 60 * rng.integers(0, 2)
        walls[door : door + 14, column : column + 2] = False
    walls[60:62] = True
    for column in (6, 46, 86, 126):
        door = column + rng.integers(0, 16)
        walls[60:62, door : door + 14] = False
    return World(walls)


def pillars(seed: int) -> World:
    """Draw forty pillars of 0.15 m in a hall of 6 m."""
    rng = np.random.default_rng(seed)
    walls = _walled(120, 120)
    for row, column in rng.integers(4, 114, (40, 2)):
        walls[row : row + 3, column : column + 3] = True
    return World(walls)


def journey(world: World, seed: int) -> tuple[Pose2D, Pose2D, PlanResult]:
    """Draw a start and a distant goal; return both and the plan between them."""
    rng = np.random.default_rng(seed)
    free = np.argwhere(world.costmap.data < 240)
    start = free[rng.integers(len(free))]
    values = cost_field(world.costmap, cells=start)
    far = np.argwhere(np.isfinite(values) & (values > np.median(values[np.isfinite(values)])))
    goal = far[rng.integers(len(far))]
    ends = [Pose2D(*world.costmap.info.to_world(cell).tolist(), rng.uniform(-3.0, 3.0)) for cell in (start, goal)]
    return ends[0], ends[1], Dijkstra().plan(world.costmap, PlanRequest(ends[0], ends[1]))


def _walled(height: int, width: int) -> np.ndarray:
    walls = np.zeros((height, width), bool)
    walls[[0, -1]] = True
    walls[:, [0, -1]] = True
    return walls
