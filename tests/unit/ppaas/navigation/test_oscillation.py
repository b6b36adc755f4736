"""Detection of a robot that oscillates."""

from ppaas.geometry import Pose2D
from ppaas.navigation.move_base import Oscillation


def test_the_first_place_counts_as_left():
    watch = Oscillation(0.5, 10.0)
    assert watch.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.has_left(1.0, Pose2D(0.4, 0, 0))


def test_distance_is_measured_from_the_last_place_left():
    watch = Oscillation(0.5, 10.0)
    watch.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.has_left(1.0, Pose2D(0.3, 0, 0))
    assert watch.has_left(2.0, Pose2D(0.6, 0, 0))


def test_turning_does_not_count_as_leaving():
    watch = Oscillation(0.5, 10.0)
    watch.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.has_left(1.0, Pose2D(0, 0, 3))


def test_timeout_applies_only_if_positive():
    watch, never = Oscillation(0.5, 10.0), Oscillation(0.5, 0.0)
    for each in (watch, never):
        each.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.timed_out(10.0)
    assert watch.timed_out(10.1)
    assert not never.timed_out(1e9)
    watch.reset(10.0)
    assert not watch.timed_out(20.0)
