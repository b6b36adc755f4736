"""Messages of mapping: the covariance and entropy of a pose."""

import math

import msgspec
import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.occupancy import GridUpdate
from ppaas.messages.base.std_msgs import Time
from ppaas.nodes.grid_slam.publishing import entropy_of, robot_covariance


def test_a_change_is_a_message_with_its_cells_row_by_row():
    cells = np.array([[-1, 0, 100], [100, 50, -1]], np.int8)
    message = GridUpdate(cells[:, :2], 7, 3, Time(5, 0)).to_message()
    assert (message.x, message.y, message.width, message.height) == (3, 7, 2, 2)
    assert msgspec.json.decode(message.data) == [-1, 0, 100, 50]
    assert (message.header.frame_id, message.header.stamp) == ("map", Time(5, 0))


def test_the_covariance_of_the_robot_is_that_of_sampled_poses():
    random = np.random.default_rng(2)
    root = np.diag((0.02, 0.05, 0.01)) @ (np.eye(3) + 0.3 * random.standard_normal((3, 3)))
    own = root @ root.T
    laser, mount = Pose2D(3.0, -2.0, 0.8), Pose2D(0.3, 0.1, 0.4)
    noise = root @ random.standard_normal((3, 20_000))
    robots = np.array([laser @ Pose2D(*step) @ mount.inverse() for step in noise.T.tolist()])
    information = np.linalg.inv(own)[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    found = robot_covariance(information, laser, laser @ mount.inverse())
    np.testing.assert_allclose(found, np.cov(robots.T), atol=0.04 * own.max())


def test_no_information_is_a_wide_covariance():
    found = robot_covariance(np.zeros(6), Pose2D(0.0, 0.0), Pose2D(0.0, 0.0))
    np.testing.assert_allclose(np.diag(found), 100.0)


@pytest.mark.parametrize("factor", [1.0, 4.0])
def test_entropy_is_that_of_the_normal_distribution(factor):
    normal = 1.5 * math.log(2.0 * math.pi * math.e)
    assert entropy_of(factor * np.eye(3)) == pytest.approx(normal + 1.5 * math.log(factor))
