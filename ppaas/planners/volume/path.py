"""Poses, cost and length of a path of voxels."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.geometry import Poses
from ppaas.planners.base3d import Pose3D
from ppaas.planners.weights import exact_weights


def path_cost(costmap: VoxelCostmap, cells: NDArray[np.int32]) -> float:
    """Return the cost of a path, computed in float64.

    As in the plane, a move weighs as much as the voxel nearer to the start. All voxels count except the goal.

    Parameters
    ----------
    costmap : VoxelCostmap
    cells : (n, 3) array
        Layer, row, column from start to goal.
    """
    layers, rows, columns = cells[:-1].T
    weights = exact_weights()[costmap.data[layers, rows, columns]]
    return float(np.sum(weights * np.sqrt(np.abs(np.diff(cells, axis=0)).sum(axis=1))))


def path_poses(costmap: VoxelCostmap, cells: NDArray[np.int32], start: Pose3D, goal: Pose3D) -> Poses:
    """Return the (n, 7) poses of a path: the places of its voxels, with ``start`` and ``goal`` at its ends.

    Each pose heads for the next one; a vertical move keeps the heading. If both ends are in one voxel, the only pose is
    the goal.
    """
    points = costmap.places(cells)
    points[0] = start[:3]
    points[-1] = goal[:3]
    yaws = np.full(len(cells), start.theta)
    steps = np.diff(points, axis=0)
    moved = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) > 0.0)
    moved = moved[moved > 0]
    if len(moved):
        last = np.searchsorted(moved, np.arange(len(cells)), side="right") - 1
        headings = np.arctan2(steps[moved, 1], steps[moved, 0])
        yaws = np.where(last < 0, start.theta, headings[last])
    yaws[-1] = goal.theta
    poses = np.zeros((len(cells), 7))
    poses[:, :3] = points
    poses[:, 5], poses[:, 6] = np.sin(yaws / 2.0), np.cos(yaws / 2.0)
    return poses


def path_length(poses: Poses) -> float:
    """Return the length along the poses [m]."""
    return float(np.sum(np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1)))
