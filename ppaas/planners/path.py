"""Poses, cost and length of a path of cells."""

import functools
import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, Poses, poses_along, quaternion_of
from ppaas.kernel_threads import limit_threads
from ppaas.planners.kernels.path_poses import add_costs, fill_poses
from ppaas.planners.weights import exact_weights

Cells = NDArray[np.int32]

FEW = 1 << 15
"""Longest path whose poses one thread computes [cells]: that takes 0.2 ms, too short for helpers on a busy machine."""

_WEIGHTS = exact_weights()


def path_cost(costmap: Costmap, cells: Cells) -> float:
    """Return the cost of a path, computed in float64.

    The cost field grows from the goal, so a move weighs as much as the cell nearer to the start. All cells count except
    the goal.

    Parameters
    ----------
    costmap : Costmap
    cells : (n, 2) int32 array
        Row, column from start to goal, each a neighbour of the one before.
    """
    cells = np.ascontiguousarray(cells, np.int32)
    return float(add_costs(cells, costmap.data[cells[:, 0], cells[:, 1]], _WEIGHTS))


def path_poses(costmap: Costmap, cells: Cells, start: Pose2D, goal: Pose2D, *, threads: int = 1) -> Poses:
    """Return the (n, 7) poses of a path: the centres of its cells, with ``start`` and ``goal`` at its ends.

    If both are in one cell, the only pose is the goal. Headings are computed from the cells, not from the rounded
    centres, so that equal moves have exactly equal headings everywhere on the map.

    Parameters
    ----------
    costmap : Costmap
    cells : (n, 2) int32 array
        Row, column from start to goal, each a neighbour of the one before.
    start, goal : Pose2D
        Poses in the first and in the last cell.
    threads : int
        Maximum number of threads.
    """
    info = costmap.info
    cells = np.ascontiguousarray(cells, np.int32)
    poses = np.empty((len(cells), 7))
    frame = np.array((info.resolution, *info.origin[:2], math.cos(info.origin.theta), math.sin(info.origin.theta)))
    headings = _headings(info.origin.theta)
    if len(cells) > FEW:
        with limit_threads(threads) as usable:
            fill_poses(cells, frame, headings, poses, usable)
    else:
        fill_poses(cells, frame, headings, poses, 1)
    if len(cells) > 2:
        ahead = math.atan2(goal.y - poses[-2, 1], goal.x - poses[-2, 0])
        poses[-2, 3:] = quaternion_of(ahead)
    _set_pose(poses[0], start)
    _set_pose(poses[-1], goal)
    return poses


def poses_through(costmap: Costmap, points: NDArray[np.float64], start: Pose2D, goal: Pose2D) -> Poses:
    """Return the (n, 7) poses of a path that does not run through the centres of cells.

    Parameters
    ----------
    costmap : Costmap
    points : (n, 2) array
        Row, column from start to goal, with fractions; whole numbers are centres.
    start, goal : Pose2D
        The first and the last pose.
    """
    places = costmap.info.to_world(points)
    places[0] = start.x, start.y
    places[-1] = goal.x, goal.y
    poses = poses_along(places, goal.theta)
    if len(places) > 1:
        poses[0, 3:] = quaternion_of(start.theta)
    return poses


def path_length(poses: Poses) -> float:
    """Return the length along the poses [m]."""
    steps = np.diff(poses[:, :2], axis=0)
    return float(np.sum(np.hypot(steps[:, 0], steps[:, 1])))


@functools.lru_cache(maxsize=64)
def _headings(turned: float) -> NDArray[np.float64]:
    """Return the (3, 3, 2) qz, qw of the moves on a map rotated by ``turned`` [rad]; index = rows + 1, columns + 1."""
    rows, columns = np.meshgrid((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), indexing="ij")
    c, s = math.cos(turned), math.sin(turned)
    yaw = np.arctan2(s * columns + c * rows, c * columns - s * rows)
    headings = np.stack((np.sin(yaw / 2.0), np.cos(yaw / 2.0)), axis=-1)
    headings.setflags(write=False)
    return headings


def _set_pose(pose: NDArray[np.float64], place: Pose2D) -> None:
    pose[:2], pose[3:] = place[:2], quaternion_of(place.theta)
