import math
from dataclasses import asdict

import pytest
from msgspec import structs

from ppaas.controllers.base import VelocityLimits
from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter
from ppaas.parameters import read_parameters


def test_default_limits_equal_those_of_velocity_limits():
    limits = asdict(VelocityLimits())
    assert limits.items() <= structs.asdict(DriveParameters()).items()


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
def test_invalid_parameters_are_refused_by_name(name, value):
    with pytest.raises(InvalidParameter, match=name):
        read_parameters(DriveParameters, "dwa", {name: value})
