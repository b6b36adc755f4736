import math

import numpy as np
import pytest

from benchmarks.navigation.barn.dead_ends import DeadEnds
from ppaas.geometry import Pose2D, poses_along
from tests.support.world import grids

PLAN = poses_along(np.stack((np.arange(0.5, 4.0, 0.05), np.full(70, 1.0)), axis=1))


def ground():
    data = np.zeros((40, 80), np.uint8)
    data[:, 24:27] = 200
    data[:, 30:32] = 120
    return grids.of(data, 0.05)


def test_where_it_gets_no_farther_the_narrowest_place_ahead_is_shut():
    impasses = DeadEnds()
    here = Pose2D(0.6, 1.0)
    assert not any(impasses.look(0.05 * cycle, here, PLAN, ground()) for cycle in range(40))
    assert impasses.look(2.1, here, PLAN, ground())
    [(x, y, radius)] = impasses.discs
    assert (x, y) == (pytest.approx(1.27, abs=0.08), 1.0)
    assert radius > 0.0
    assert not impasses.look(2.2, here, PLAN, ground())
    impasses.forget()
    assert impasses.discs == []


def test_a_robot_that_gets_on_shuts_nothing():
    impasses = DeadEnds()
    for cycle in range(200):
        assert not impasses.look(0.05 * cycle, Pose2D(0.5 + 0.015 * cycle, 1.0), PLAN, ground())


def test_at_the_end_of_its_plan_there_is_nothing_to_shut():
    impasses = DeadEnds()
    assert not any(impasses.look(0.1 * cycle, Pose2D(3.95, 1.0), PLAN, ground()) for cycle in range(60))


def test_where_it_came_through_nothing_is_shut_while_it_turns_round():
    impasses = DeadEnds()
    for cycle in range(100):
        impasses.look(0.05 * cycle, Pose2D(3.5 - 0.03 * cycle, 1.0, math.pi), PLAN, ground())
    there = Pose2D(0.5, 1.0, 0.0)
    assert not any(impasses.look(5.0 + 0.05 * cycle, there, PLAN, ground()) for cycle in range(100))
    assert impasses.discs == []
