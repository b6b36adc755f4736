"""Views of detectors: limits of range and bearing, and people who hide others."""

import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from ppaas.people.tracks.robot_tracker import hides, sees

ROBOT = Pose2D(1.0, 1.0, math.pi / 2.0)
AHEAD = SensorView(0.5, 0.0, 0.0, 1.0, 0.5, 5.0)
AROUND = SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.2, 5.0)


@pytest.mark.parametrize(
    ("place", "seen"),
    [((1.0, 3.0), True), ((1.0, 1.8), False), ((1.0, 6.8), False), ((2.5, 3.0), False), ((1.0, -1.0), False)],
)
def test_point_is_in_the_view_of_a_camera_by_range_and_bearing(place, seen):
    assert sees(AHEAD, ROBOT, *place) is seen


def test_laser_sees_behind_the_robot():
    assert sees(AROUND, ROBOT, 1.0, -1.0)


def test_person_before_another_hides_them():
    assert hides(AHEAD, ROBOT, (1.0, 3.0), 1.1, 5.0)
    assert not hides(AHEAD, ROBOT, (1.1, 5.0), 1.0, 3.0)
    assert not hides(AHEAD, ROBOT, (1.0, 3.0), 2.5, 5.0)
