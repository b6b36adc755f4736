"""From the cells of a path to its poses, cost and length."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, Poses, poses_along, quaternion_of
from ppaas.planners.weights import SQRT2, exact_weights


def path_cost(costmap: Costmap, cells: NDArray[np.int32]) -> float:
    """Recount what a path costs, in float64.

    The field of costs grows from the goal, so a move weighs what the cell nearer to the start weighs: all cells
    count but the goal's.

    Parameters
    ----------
    costmap : Costmap
    cells : (n, 2) array
        Row, column from start to goal.
    """
    weights = exact_weights()[costmap.data[cells[:-1, 0], cells[:-1, 1]]]
    diagonal = (cells[1:, 0] != cells[:-1, 0]) & (cells[1:, 1] != cells[:-1, 1])
    return float(np.sum(weights * np.where(diagonal, SQRT2, 1.0)))


def path_poses(costmap: Costmap, cells: NDArray[np.int32] | NDArray[np.float64], start: Pose2D, goal: Pose2D) -> Poses:
    """Return the (n, 7) poses of a path: the centres of its cells, with ``start`` and ``goal`` themselves at its ends.

    Where both lie in one cell, the only pose is the goal. A path that does not run through centres is given by rows
    and columns with fractions.
    """
    points = costmap.info.to_world(cells)
    points[0] = start.x, start.y
    points[-1] = goal.x, goal.y
    poses = poses_along(points, goal.theta, _steps(costmap, cells, points))
    if len(points) > 1:
        poses[0, 3:] = quaternion_of(start.theta)
    return poses


def _steps(
    costmap: Costmap, cells: NDArray[np.int32] | NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the steps between points; those from cell to cell as the cells tell, so that equal moves are equal.

    Points are rounded, so that no two diagonal steps head for quite the same; equal stretches of paths are to have
    equal poses, wherever they are asked for.
    """
    steps: NDArray[np.float64] = np.diff(points, axis=0)
    if np.issubdtype(cells.dtype, np.integer):
        y, x = np.diff(cells, axis=0)[1:-1].T.astype(np.float64)
        c, s = math.cos(costmap.info.origin.theta), math.sin(costmap.info.origin.theta)
        steps[1:-1, 0], steps[1:-1, 1] = c * x - s * y, s * x + c * y
    return steps


def path_length(poses: Poses) -> float:
    """Return the length along the poses [m]."""
    steps = np.diff(poses[:, :2], axis=0)
    return float(np.sum(np.hypot(steps[:, 0], steps[:, 1])))
