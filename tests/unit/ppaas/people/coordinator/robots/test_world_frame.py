"""Step 2: torso coordinates to the world frame."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.people.coordinator.positions import to_world

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
