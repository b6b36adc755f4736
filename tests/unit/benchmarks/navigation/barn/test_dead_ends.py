import math

import numpy as np
import pytest

from benchmarks.navigation.barn.navigator import DeadEnds
from ppaas.geometry import Pose2D, poses_along
from tests.support.world import grids

PLAN = poses_along(np.stack((np.arange(0.5, 4.0, 0.05), np.full(70, 1.0)), axis=1))


def costmap():
    data = np.zeros((40, 80), np.uint8)
    data[:, 24:27] = 200
    data[:, 30:32] = 120
    return grids.of(data, 0.05)


def test_the_narrowest_place_ahead_is_blocked_without_progress():
    dead_ends = DeadEnds()
    here = Pose2D(0.6, 1.0)
    assert not any(dead_ends.look(0.05 * cycle, here, PLAN, costmap()) for cycle in range(40))
    assert dead_ends.look(2.1, here, PLAN, costmap())
    [(x, y, radius)] = dead_ends.discs
    assert (x, y) == (pytest.approx(1.27, abs=0.08), 1.0)
    assert radius > 0.0
    assert not dead_ends.look(2.2, here, PLAN, costmap())
    dead_ends.forget()
    assert dead_ends.discs == []


def test_a_robot_that_makes_progress_blocks_nothing():
    dead_ends = DeadEnds()
    for cycle in range(200):
        assert not dead_ends.look(0.05 * cycle, Pose2D(0.5 + 0.015 * cycle, 1.0), PLAN, costmap())


def test_nothing_is_blocked_at_the_end_of_the_plan():
    dead_ends = DeadEnds()
    assert not any(dead_ends.look(0.1 * cycle, Pose2D(3.95, 1.0), PLAN, costmap()) for cycle in range(60))


def test_places_already_passed_are_not_blocked():
    dead_ends = DeadEnds()
    for cycle in range(100):
        dead_ends.look(0.05 * cycle, Pose2D(3.5 - 0.03 * cycle, 1.0, math.pi), PLAN, costmap())
    there = Pose2D(0.5, 1.0, 0.0)
    assert not any(dead_ends.look(5.0 + 0.05 * cycle, there, PLAN, costmap()) for cycle in range(100))
    assert dead_ends.discs == []
