import math

import pytest

from ppaas.controllers.arrival import Arrival, turn_by
from ppaas.controllers.base import Velocity
from ppaas.controllers.dwa_parameters import DwaParameters
from ppaas.geometry import Pose2D

PARAMETERS = DwaParameters()
GOAL = Pose2D(2.0, 1.0, math.pi / 2)


def test_it_arrives_well_within_the_tolerance_or_where_the_goal_is_not_in_front():
    well_within, in_front, beside, far = (
        Pose2D(1.96, 1.0), Pose2D(1.92, 1.0), Pose2D(1.92, 1.0, 2.0), Pose2D(1.8, 1.0),
    )  # fmt: skip
    for pose, there in ((well_within, True), (in_front, False), (beside, True), (far, False)):
        assert Arrival(PARAMETERS).arrive(pose, GOAL) is there


def test_once_there_it_may_be_pushed_as_far_again_but_another_goal_is_another():
    arrival = Arrival(PARAMETERS)
    assert arrival.head_for(GOAL)
    assert arrival.arrive(Pose2D(1.97, 1.0), GOAL)
    assert not arrival.head_for(GOAL)
    assert arrival.arrive(Pose2D(1.85, 1.0), GOAL)
    assert arrival.head_for(Pose2D(2.0, 1.0, 0.0))
    assert not arrival.arrive(Pose2D(1.85, 1.0), GOAL)


def test_it_is_reached_when_it_stands_there_and_looks_as_asked():
    arrival = Arrival(PARAMETERS)
    assert arrival.is_reached(Pose2D(1.95, 1.0, 1.5), Velocity(), GOAL)
    assert not arrival.is_reached(Pose2D(1.95, 1.0, 1.5), Velocity(0.3, 0.0), GOAL)
    assert not arrival.is_reached(Pose2D(1.95, 1.0, 0.5), Velocity(), GOAL)
    assert not arrival.is_reached(Pose2D(1.5, 1.0, 1.5), Velocity(), GOAL)


def test_it_stops_before_it_turns():
    arrival = Arrival(PARAMETERS)
    assert arrival.settle(Pose2D(2.0, 1.0), GOAL, Velocity(0.3, 0.0), 0.1) == pytest.approx((0.2, 0.0))
    assert arrival.settle(Pose2D(2.0, 1.0), GOAL, Velocity(), 0.1).angular > 0.0
    assert arrival.settle(Pose2D(2.0, 1.0, math.pi / 2), GOAL, Velocity(), 0.1) == (0.0, 0.0)


def test_facing_backwards_it_keeps_to_the_side_that_it_turns_to():
    assert turn_by(-3.1, Velocity(0.0, 0.5), PARAMETERS, 0.1).angular > 0.0
    assert turn_by(-2.0, Velocity(0.0, 0.2), PARAMETERS, 0.1).angular < 0.2
