"""From the cells of a path to its poses, cost and length."""

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
    diagonal = np.abs(np.diff(cells, axis=0)).sum(axis=1) == 2
    return float(np.sum(weights * np.where(diagonal, SQRT2, 1.0)))


def path_poses(costmap: Costmap, cells: NDArray[np.int32] | NDArray[np.float64], start: Pose2D, goal: Pose2D) -> Poses:
    """Return the (n, 7) poses of a path: the centres of its cells, with ``start`` and ``goal`` themselves at its ends.

    Where both lie in one cell, the only pose is the goal. A path that does not run through centres is given by rows
    and columns with fractions.
    """
    points = costmap.info.to_world(cells)
    points[0] = start.x, start.y
    points[-1] = goal.x, goal.y
    poses = poses_along(points, goal.theta)
    if len(points) > 1:
        poses[0, 3:] = quaternion_of(start.theta)
    return poses


def path_length(poses: Poses) -> float:
    """Return the length along the poses [m]."""
    steps = np.diff(poses[:, :2], axis=0)
    return float(np.sum(np.hypot(steps[:, 0], steps[:, 1])))
