"""Checks of every path for a robot with a minimum turning radius."""

import itertools
import math

import numpy as np
import pytest

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, yaw_of
from ppaas.planners.base import PlanResult
from ppaas.planners.path import path_cost, path_length
from tests.reference.planners import driving as twin
from tests.reference.planners.curves import same_heading


def assert_drivable(
    costmap: Costmap, result: PlanResult, start: Pose2D, goal: Pose2D, radius: float, *, backing: bool, footprint=()
) -> int:
    """Check a path that begins in a free cell; return how often it changes between forward and backward."""
    poses = [Pose2D(row[0], row[1], yaw_of(*row[3:])) for row in result.poses.tolist()]
    for pose, asked in ((poses[0], start), (poses[-1], goal)):
        assert (pose.x, pose.y) == (asked.x, asked.y)
        assert same_heading(pose.theta, asked.theta) < 1e-6
    gears = [_gear(a, b, radius, costmap.info.resolution) for a, b in itertools.pairwise(poses)]
    assert backing or -1 not in gears
    _assert_cells(costmap, result, poses)
    lethal = costmap.data == 254
    for pose in poses:
        if len(footprint):
            x, y, theta = costmap.info.origin.inverse() @ pose
            corners = [(a / costmap.info.resolution, b / costmap.info.resolution) for a, b in footprint]
            place = x / costmap.info.resolution, y / costmap.info.resolution, theta
            assert twin.outline_is_free(lethal, twin.placed(corners, place), outside=True)
    assert result.cost == path_cost(costmap, result.cells)
    assert result.length == path_length(result.poses)
    driven = [gear for gear in gears if gear]
    return sum(a != b for a, b in itertools.pairwise(driven))


def _gear(a: Pose2D, b: Pose2D, radius: float, most: float) -> int:
    """Return 1, −1 or 0 for a step forward, backward, or on the spot, and check that the robot can drive it."""
    turn = math.remainder(b.theta - a.theta, 2 * math.pi)
    chord = math.dist(a[:2], b[:2])
    assert chord <= most
    assert abs(turn) <= chord / radius * 1.01 + 1e-6 or chord >= 2 * radius * math.sin(abs(turn) / 2) - 1e-7
    if chord < 1e-7:
        return 0
    # An arc's chord points midway between the headings at its ends.
    off = math.remainder(math.atan2(b.y - a.y, b.x - a.x) - (a.theta + turn / 2), 2 * math.pi)
    forward = abs(off) < math.pi / 2
    assert abs(off if forward else math.pi - abs(off)) < 1e-4
    return 1 if forward else -1


def _assert_cells(costmap: Costmap, result: PlanResult, poses: list[Pose2D]) -> None:
    cells = [tuple(cell) for cell in result.cells.tolist()]
    assert cells[0] == costmap.info.cell_of(*poses[0][:2])
    assert cells[-1] == costmap.info.cell_of(*poses[-1][:2])
    crossed = [tuple(cell) for cell, _ in itertools.groupby(costmap.info.to_cells(result.poses[:, :2]).tolist())]
    assert cells == pytest.approx(np.array(crossed))
    for (r, c), (row, column) in itertools.pairwise(cells):
        assert max(abs(r - row), abs(c - column)) == 1
        for cell in ((row, column), (r, column), (row, c)):
            assert costmap.data[cell] < 253 or costmap.data[cell] == 255
