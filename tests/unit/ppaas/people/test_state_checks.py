"""Checks of the coordinator's messages."""

import math

import pytest

from ppaas.errors import InvalidInput
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import GroupRobot, PeopleState, TrackedPerson
from ppaas.people.state_checks import check_state


def state(x: float = 1.0, vx: float = 0.0, robot_x: float = 0.0) -> PeopleState:
    person = TrackedPerson(3, Point(x, 0.0), Point(vx, 0.0), [0.0] * 4)
    return PeopleState(Header(), 1, [person], robots=[GroupRobot("r", Point(robot_x, 0.0), 0.1)])


def test_finite_states_pass():
    check_state(state())


@pytest.mark.parametrize(
    ("wrong", "named"),
    [(state(x=math.nan), "person 3"), (state(vx=math.inf), "person 3"), (state(robot_x=-math.inf), "robot 'r'")],
)
def test_numbers_that_are_not_finite_are_refused_by_name(wrong, named):
    with pytest.raises(InvalidInput, match=named):
        check_state(wrong)
