"""Cells of a map that are wrong, by the walls of the simulated world."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import Segments
from ppaas.mapping.pipeline.offline import LogMap
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.planar_poses import PoseArray, compose, relative
from robots.demo.map_score import wrong_cells


def wrong_share(made: LogMap, walls: Segments, true: PoseArray) -> float:
    """Return the part of the known cells that are wrong; the edge of a wall may be off by one cell.

    Parameters
    ----------
    made : LogMap
    walls : (n, 4) array
        In the frame of the true poses.
    true : (n, 3) array
        True poses of the robot: the map is laid on the walls where its first pose is the true one.
    """
    grid = made.grid()
    origin = compose(true[0], relative(made.poses[0], np.zeros(3)))
    ends = walls.reshape(-1, 2)
    in_map = relative(origin, np.column_stack((ends, np.zeros(len(ends)))))[:, :2].reshape(-1, 4)
    wrong, known = wrong_cells(grid, GridMap(_drawn(in_map, grid.info), grid.info))
    return wrong / max(known, 1)


def _drawn(walls: Segments, info: GridInfo) -> NDArray[np.int8]:
    """Return cells that are occupied where a wall is, and free elsewhere."""
    cells = np.full((info.height, info.width), FREE, np.int8)
    for x0, y0, x1, y1 in walls.tolist():
        count = 2 + int(4.0 * np.hypot(x1 - x0, y1 - y0) / info.resolution)
        points = np.column_stack((np.linspace(x0, x1, count), np.linspace(y0, y1, count)))
        at = info.to_cells(points)
        at = at[((at >= 0) & (at < (info.height, info.width))).all(axis=1)]
        cells[at[:, 0], at[:, 1]] = OCCUPIED
    return cells
