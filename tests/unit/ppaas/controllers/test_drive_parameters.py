import math

import pytest

from ppaas.controllers.base import VelocityLimits
from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter


def test_the_limits_are_those_of_every_base():
    assert isinstance(DriveParameters(), VelocityLimits)
    assert DriveParameters(max_vel_x=1, min_vel_x=-1).max_vel_x == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_vel_x", 0.0),
        ("max_vel_theta", math.nan),
        ("acc_lim_x", -1.0),
        ("acc_lim_theta", True),
        ("xy_goal_tolerance", -0.1),
        ("robot_radius", "wide"),
        ("allow_unknown", 1),
        ("min_vel_x", 0.6),
        ("min_vel_trans", 0.6),
        ("min_vel_theta", 2.0),
    ],
)
def test_what_cannot_be_is_refused_by_name(name, value):
    with pytest.raises(InvalidParameter, match=name):
        DriveParameters(**{name: value})
