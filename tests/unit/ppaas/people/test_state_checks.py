"""Checks of messages between robots and their coordinator."""

import math

import pytest

from ppaas.errors import InvalidInput
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import GroupRobot, PeopleState, SensorView, TrackedPerson
from ppaas.people.state_checks import check_state, check_view


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


@pytest.mark.parametrize(("field_of_view", "range_max"), [(math.nan, 5.0), (-1.0, 5.0), (1.0, math.inf), (1.0, 1e300)])
def test_view_that_no_sensor_has_is_refused(field_of_view, range_max):
    with pytest.raises(InvalidInput, match="the view"):
        check_view(SensorView(0.0, 0.0, 0.0, field_of_view, 0.3, range_max), "the view")
