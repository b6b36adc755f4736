import math
from dataclasses import asdict

import pytest
from msgspec import structs

from ppaas.controllers.base import VelocityLimits
from ppaas.controllers.drive_parameters import DriveParameters, body_of, check_footprint
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


BOX = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))


def test_footprint_may_have_either_orientation_or_be_empty():
    for footprint in (BOX, BOX[::-1], ()):
        check_footprint(footprint)


@pytest.mark.parametrize(
    "wrong",
    [
        ((0.1, 0.1),),
        ((0.1, 0.1), (0.2, 0.2)),
        ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)),
        ((0.2, math.inf), (-0.2, 0.2), (-0.2, -0.2)),
        ((0.2, math.nan), (-0.2, 0.2), (-0.2, -0.2)),
    ],
)
def test_invalid_footprint_is_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match="footprint"):
        check_footprint(wrong)


def test_body_has_inscribed_and_circumscribed_radii():
    box = body_of(BOX, 0.0)
    assert (box.inscribed, box.circumscribed) == pytest.approx((0.2, math.hypot(0.3, 0.2)))
    assert box.edges[0] == pytest.approx((0.3, 0.2, -1.0, 0.0, 0.6))
    disc = body_of((), 0.25)
    assert (len(disc.edges), disc.inscribed, disc.circumscribed) == (0, 0.25, 0.25)
