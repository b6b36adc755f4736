"""A clone whose map has an octomap drives only where its robot fits, even if the laser sees no obstacle."""

import math

import numpy as np
import pytest

from ppaas.costmap.filter_masks import height_mask
from ppaas.geometry import Pose2D
from ppaas.maps.octree import OcTree, octree_of
from ppaas.maps.voxels import Point3D, VoxelGrid, VoxelInfo
from ppaas.messages.actionlib_msgs import Status
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import Box, World, walled_map

START, GOAL = Pose2D(0.7, 2.0, 0.0), Pose2D(5.3, 2.0, 0.0)
TOP = 0.7
"""Height of the boards under which the laser looks through [m]."""

TABLE: Box = (2.5, 1.4, 3.5, 2.6)
SHELF: Box = (2.5, 0.0, 3.5, 4.0)
LOW, MAST = 0.42, 1.2


def octree(board: Box) -> OcTree:
    """Return a room of 6 × 4 m with a floor and a board, in voxels of 0.1 m."""
    data = np.zeros((22, 40, 60), np.uint8)
    data[0] = 100
    x0, y0, x1, y1 = (round(10 * edge) for edge in board)
    data[1 + round(10 * TOP), y0:y1, x0:x1] = 100
    return octree_of(VoxelGrid(data, VoxelInfo(0.1, 60, 40, 22, Point3D(0.0, 0.0, -0.1))))


def driven(board: Box, height: float, **options) -> tuple[ClosedLoop, float]:
    """Return the loop after its goal, and the smallest distance of the robot's centre to the board [m]."""
    room = walled_map(6, 4, [])
    overhead = height_mask(octree(board), room.info, lowest=None, highest=height)
    driving = ClosedLoop(World(room, START), masks={"overhead": overhead}, **options)
    for _ in range(6):
        driving.step()
    driving.send_goal(GOAL)
    nearest = math.inf
    for _ in range(1200):
        driving.step()
        x, y, _ = driving.world.pose
        away = math.hypot(max(board[0] - x, 0.0, x - board[2]), max(board[1] - y, 0.0, y - board[3]))
        nearest = min(nearest, away)
        if driving.results:
            break
    return driving, nearest


@pytest.mark.parametrize("planner", ["dwa", "mppi"])
def test_robot_drives_around_a_table_only_if_it_has_a_mast(planner):
    around, nearest = driven(TABLE, MAST, base_local_planner=planner)
    assert around.last_status() is Status.SUCCEEDED, around.results[-1].status.text
    assert nearest > 0.18
    under, nearest = driven(TABLE, LOW, base_local_planner=planner)
    assert under.last_status() is Status.SUCCEEDED
    assert nearest == 0.0
    assert max(plan.length for plan in around.plans) > max(plan.length for plan in under.plans) + 0.2


def test_goal_is_aborted_at_once_if_the_mast_fits_nowhere():
    refused, nearest = driven(SHELF, MAST)
    assert refused.last_status() is Status.ABORTED
    assert "no free path" in refused.results[-1].status.text
    assert nearest > 1.5
    assert driven(SHELF, LOW)[0].last_status() is Status.SUCCEEDED
