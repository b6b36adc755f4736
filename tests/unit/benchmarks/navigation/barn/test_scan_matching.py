"""Scan matching corrects odometry by earlier scans."""

import math

import numpy as np
import pytest

from benchmarks.navigation.barn.jackal import NOISE
from benchmarks.navigation.barn.scan_matching import ScanMatching
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D, wrap_angle
from robots.sim.laser import cast_at_discs

HERE = Pose2D(0.0, 0.0, 0.0)
ANGLES = NOISE["hard"].laser.angles


def reading(pose: Pose2D, centres: np.ndarray, rng: np.random.Generator, odom: Pose2D) -> LaserReading:
    ranges = cast_at_discs(pose, ANGLES, centres, 0.075)
    return LaserReading(odom, ANGLES, ranges + rng.normal(0.0, 0.01, len(ranges)))


def drive(centres: np.ndarray, metres: float, turn: float, seed: int) -> tuple[Pose2D, Pose2D, Pose2D]:
    """Drive an arc with wheels that measure 5 % too much and a gyro 3 %.

    Return the true pose, the pose by odometry alone, and the matched one.
    """
    rng, matching = np.random.default_rng(seed), ScanMatching()
    true = odom = predicted = HERE
    for _ in range(round(metres / 0.05)):
        true = true @ Pose2D(0.05, 0.0, 0.05 * turn)
        odom = odom @ Pose2D(0.05 * 1.05, 0.0, 0.05 * turn * 1.03)
        predicted = matching.correct(odom, reading(true, centres, rng, odom))
    return true, odom, predicted


def off(predicted: Pose2D, true: Pose2D) -> tuple[float, float]:
    return predicted.distance_to(true), abs(wrap_angle(predicted.theta - true.theta))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_scan_matching_corrects_drift_among_pillars(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pillars = rng.uniform((-6.0, -4.0), (6.0, 8.0), (60, 2))
    # No pillar on the route, a circle of 4 m diameter.
    pillars = pillars[np.abs(np.hypot(pillars[:, 0], pillars[:, 1] - 2.0) - 2.0) > 0.3]
    true, odom, predicted = drive(pillars, 25.0, 0.5, seed)
    assert off(odom, true)[0] > 0.4 or off(odom, true)[1] > 0.3
    distance, turn = off(predicted, true)
    assert distance < 0.06
    assert turn < 0.02


def test_between_two_walls_only_heading_and_lateral_position_are_matched() -> None:
    along = np.arange(-3.0, 16.0, 0.02)
    walls = np.concatenate([np.column_stack((along, np.full(len(along), y))) for y in (-1.0, 1.0)])
    true, odom, predicted = drive(walls, 8.0, 0.0, 1)
    assert abs(predicted.y - true.y) < 0.02
    assert abs(predicted.theta) < 0.01
    assert predicted.x == pytest.approx(odom.x, abs=0.3)


def test_odometry_is_used_without_visible_obstacles() -> None:
    matching, odom = ScanMatching(), HERE
    for _ in range(20):
        odom = odom @ Pose2D(0.1, 0.0, 0.1)
        predicted = matching.correct(odom, LaserReading(odom, ANGLES, np.full(len(ANGLES), np.inf)))
        assert predicted.distance_to(odom) < 1e-9


def test_new_obstacles_do_not_shift_a_standing_robot() -> None:
    rng, matching = np.random.default_rng(4), ScanMatching()
    pillars = rng.uniform(-4.0, 4.0, (30, 2))
    pillars = pillars[np.hypot(pillars[:, 0], pillars[:, 1]) > 1.0]
    for k in range(40):
        walker = np.array([[1.0, -1.0 + 0.05 * k]])
        predicted = matching.correct(HERE, reading(HERE, np.concatenate((pillars, walker)), rng, HERE))
    assert off(predicted, HERE)[0] < 0.02
    assert math.degrees(off(predicted, HERE)[1]) < 0.5
