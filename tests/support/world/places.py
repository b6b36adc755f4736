"""Random poses in a map that a Turtlebot can take and reach."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied, reachable
from ppaas.maps.grid import FREE, GridMap

CLEARANCE = 0.4


def roomy(grid: GridMap) -> NDArray[np.bool_]:
    """Return the free cells that are farther than ``CLEARANCE`` from obstacles."""
    return (distance_to_occupied(grid) > CLEARANCE) & (grid.data == FREE)


def free_pose(grid: GridMap, seed: int) -> Pose2D:
    """Return a random pose in the largest connected part of the map."""
    free = roomy(grid)
    rows, columns = np.nonzero(free)
    rng = np.random.default_rng(seed)
    while True:
        pick = int(rng.integers(len(rows)))
        if reachable(free, int(rows[pick]), int(columns[pick])).sum() > 0.5 * free.sum():
            x, y = grid.info.to_world((rows[pick], columns[pick]))
            return Pose2D(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))


def reachable_pose(grid: GridMap, start: Pose2D, seed: int, at_least: float, at_most: float = np.inf) -> Pose2D:
    """Return a random pose that can be reached from another, within a range of straight-line distances [m]."""
    cell = grid.info.cell_of(start.x, start.y)
    assert cell is not None
    cells = np.argwhere(reachable(roomy(grid), *cell))
    points = grid.info.to_world(cells)
    away = np.hypot(points[:, 0] - start.x, points[:, 1] - start.y)
    far = points[(away >= at_least) & (away <= at_most)]
    rng = np.random.default_rng(seed)
    x, y = far[int(rng.integers(len(far)))]
    return Pose2D(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))
