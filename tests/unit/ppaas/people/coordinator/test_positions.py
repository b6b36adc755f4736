"""Deviations, offsets and the world frame."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.people.coordinator.positions import (
    LEAST,
    UNKNOWN,
    OffsetFilter,
    maximum_position_deviation,
    position_deviation,
    to_world,
)


def covariance(xx: float, xy: float, yy: float) -> NDArray[np.float64]:
    return np.array([[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, 0.0]])


def test_the_deviation_holds_95_percent_along_the_widest_axis() -> None:
    assert position_deviation(covariance(0.04, 0.0, 0.01)) == pytest.approx(2.4477 * 0.2, rel=1e-3)


def test_the_deviation_does_not_depend_on_how_the_axes_lie() -> None:
    c, s = math.cos(0.7), math.sin(0.7)
    xx, xy, yy = c * c * 0.04 + s * s * 0.01, c * s * 0.03, s * s * 0.04 + c * c * 0.01
    assert position_deviation(covariance(xx, xy, yy)) == pytest.approx(position_deviation(covariance(0.04, 0.0, 0.01)))


def test_a_covariance_of_zeros_means_unknown() -> None:
    assert position_deviation(np.zeros((3, 3))) == UNKNOWN


def test_no_robot_is_surer_than_a_cell_of_the_map() -> None:
    assert position_deviation(covariance(1e-8, 0.0, 1e-8)) == LEAST


def test_the_maximum_over_the_history_counts() -> None:
    assert maximum_position_deviation([0.1, 0.9, 0.2]) == 0.9


def test_a_disagreement_with_other_robots_counts_as_a_deviation() -> None:
    assert maximum_position_deviation([0.1], disagreement=1.0) == 1.0


def test_a_robot_without_history_has_an_unknown_deviation() -> None:
    assert maximum_position_deviation([]) == UNKNOWN


def test_an_offset_follows_what_is_seen_for_long_and_not_one_observation() -> None:
    offset = OffsetFilter()
    offset.covariance = np.diag([0.04, 0.04, 0.01])
    means = []
    for _ in range(50):
        offset.observe(np.array([[2.0, 0.0]]), np.array([[0.4, 0.0]]), np.array([0.01 * np.eye(2)]))
        means.append(float(offset.mean[0]))
    assert means[0] < 0.15
    assert means[-1] > 0.3


NOTHING = np.zeros((3, 3))
NOISE = np.diag([0.01, 0.04])[np.newaxis]


def test_a_torso_ahead_of_a_robot_that_faces_north_is_north_of_it() -> None:
    positions, _ = to_world(Pose2D(2.0, 3.0, math.pi / 2), NOTHING, np.array([[4.0, 0.0]]), NOISE)
    assert positions[0] == pytest.approx([2.0, 7.0])


def test_the_covariance_turns_with_the_robot() -> None:
    _, spread = to_world(Pose2D(2.0, 3.0, math.pi / 2), NOTHING, np.array([[4.0, 0.0]]), NOISE)
    assert spread[0] == pytest.approx(np.diag([0.04, 0.01]))


def test_the_uncertainty_of_the_robot_is_added_that_of_the_yaw_by_the_distance() -> None:
    own = np.diag([0.1, 0.2, 0.01])
    _, spread = to_world(Pose2D(0.0, 0.0, 0.0), own, np.array([[4.0, 0.0]]), NOISE)
    assert spread[0] == pytest.approx(np.diag([0.11, 0.24 + 16.0 * 0.01]))


def test_the_covariance_is_that_of_samples() -> None:
    random = np.random.default_rng(0)
    pose, torso = Pose2D(1.0, -2.0, 0.6), np.array([3.0, 1.0])
    own = np.array([[0.02, 0.005, 0.001], [0.005, 0.03, 0.0], [0.001, 0.0, 0.002]])
    poses = random.multivariate_normal(pose, own, 20_000)
    torsos = random.multivariate_normal(torso, NOISE[0], 20_000)
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x = poses[:, 0] + c * torsos[:, 0] - s * torsos[:, 1]
    y = poses[:, 1] + s * torsos[:, 0] + c * torsos[:, 1]
    _, spread = to_world(pose, own, torso[np.newaxis], NOISE)
    assert np.cov(x, y) == pytest.approx(spread[0], abs=3e-3)


def test_a_robot_that_sees_nobody_has_no_torsos() -> None:
    positions, spread = to_world(Pose2D(0.0, 0.0, 0.0), NOTHING, np.zeros((0, 2)), np.zeros((0, 2, 2)))
    assert (positions.shape, spread.shape) == ((0, 2), (0, 2, 2))
