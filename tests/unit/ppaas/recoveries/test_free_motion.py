"""Collision check of motions that follow no plan."""

import math

import pytest

from ppaas.controllers.base import Velocity
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.geometry import Pose2D
from ppaas.recoveries.free_motion import is_free
from tests.support.world.recovering import MIDDLE, room

BACK = Velocity(-0.2, 0.0)


def with_band(cost: int, x_from: float, x_to: float):
    costmap = room()
    costmap.data[:, round(x_from / 0.05) : round(x_to / 0.05)] = cost
    return costmap


@pytest.mark.parametrize("cost", [INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION])
def test_motion_through_inscribed_lethal_or_unknown_cells_is_blocked(cost):
    band = with_band(cost, 1.55, 1.6)
    assert is_free(band, MIDDLE, BACK, 1.9)
    assert not is_free(band, MIDDLE, BACK, 2.1)
    assert not is_free(band, MIDDLE, BACK, 60.0), "a wall that the motion passes through blocks it"
    assert is_free(band, MIDDLE, Velocity(0.2, 0.0), 5.0)


def test_costs_below_inscribed_are_free():
    assert is_free(with_band(INSCRIBED_INFLATED_OBSTACLE - 1, 0.0, 4.0), MIDDLE, BACK, 5.0)


def test_motion_beyond_the_costmap_is_blocked():
    assert is_free(room(), Pose2D(0.5, 2.0), BACK, 2.4)
    assert not is_free(room(), Pose2D(0.5, 2.0), BACK, 2.6)
    assert not is_free(room(), Pose2D(-1.0, 2.0), BACK, 0.1)


def test_turning_in_place_is_always_free():
    assert is_free(with_band(INSCRIBED_INFLATED_OBSTACLE, 0.0, 4.0), MIDDLE, Velocity(0.0, 1.0), 6.0)


def test_arc_motion_is_checked_along_the_arc():
    turning = Velocity(0.5, 0.5 * math.pi / 2)
    ahead = with_band(LETHAL_OBSTACLE, 3.1, 4.0)
    assert not is_free(ahead, MIDDLE, Velocity(0.5, 0.0), 2.5)
    assert is_free(ahead, MIDDLE, turning, 2.5)


@pytest.mark.parametrize(("back_to", "free"), [(1.95, True), (1.9, True), (1.85, False), (1.0, False)])
def test_robot_in_inscribed_cells_may_leave_them_soon(back_to, free):
    assert is_free(with_band(INSCRIBED_INFLATED_OBSTACLE, back_to, 4.0), Pose2D(2.0, 2.0), BACK, 1.0) is free


def test_short_motion_may_not_end_in_inscribed_cells():
    assert not is_free(with_band(INSCRIBED_INFLATED_OBSTACLE, 1.0, 4.0), MIDDLE, BACK, 0.1)


def test_robot_may_not_leave_through_lethal_cells():
    costmap = with_band(INSCRIBED_INFLATED_OBSTACLE, 1.9, 4.0)
    costmap.data[:, 38] = LETHAL_OBSTACLE
    assert not is_free(costmap, MIDDLE, BACK, 1.0)
