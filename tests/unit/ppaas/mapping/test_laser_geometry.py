import math

import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry


def test_beams_per_turn_are_those_of_a_full_circle():
    assert LaserGeometry(-math.pi / 2.0, math.pi / 180.0, 181).beams_per_turn == 360
    clockwise = LaserGeometry(math.pi, -math.radians(0.5), 721)
    assert (clockwise.beams_per_turn, clockwise.beams_per_radian) == (720, pytest.approx(-360.0 / math.pi))


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((math.nan, 0.01, 10), "finite"),
        ((0.0, 0.01, 10, Pose2D(math.inf, 0.0, 0.0)), "finite"),
        ((0.0, 0.01, 0), "beams"),
        ((0.0, 1e-4, 10_001), "beams"),
        ((0.0, 0.0, 10), "at most one turn"),
        ((0.0, 0.01, 700), "at most one turn"),
        ((0.0, 0.01, 10, Pose2D(0.0, 0.0, 0.0), -1e-3), "time_increment"),
        ((0.0, 0.01, 10, Pose2D(0.0, 0.0, 0.0), 0.0, 1.5), "stamped_at"),
    ],
)
def test_invalid_geometry_is_refused(arguments, text):
    with pytest.raises(InvalidInput, match=text):
        LaserGeometry(*arguments)
