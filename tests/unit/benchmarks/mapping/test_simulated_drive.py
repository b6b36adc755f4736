"""Simulated drives of the mapping bench."""

import numpy as np
import pytest

from benchmarks.mapping.office import office, route
from benchmarks.mapping.simulated_drive import drive, odometry, simulate
from ppaas.geometry import Pose2D
from ppaas.planar_poses import relative

ROOM = np.array([(0.0, 0.0, 6.0, 0.0), (6.0, 0.0, 6.0, 4.0), (6.0, 4.0, 0.0, 4.0), (0.0, 4.0, 0.0, 0.0)])
SQUARE = np.array([(1.0, 1.0), (5.0, 1.0), (5.0, 3.0), (1.0, 3.0)])


def test_a_robot_visits_all_way_points_without_jumps():
    poses = drive(SQUARE)
    for point in SQUARE:
        assert np.hypot(*(poses[:, :2] - point).T).min() < 0.15
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() <= 0.025 + 1e-9


def test_scans_are_those_of_the_laser_on_the_robot():
    found = simulate(ROOM, SQUARE, 1, mount=Pose2D(0.3, 0.0))
    ahead = found.log.ranges[0, 90]
    assert ahead == pytest.approx(6.0 - 1.0 - 0.3, abs=0.03)
    assert found.log.geometry.mount == Pose2D(0.3, 0.0)
    assert 0.95 < np.isfinite(found.log.ranges).mean() < 1.0


def test_equal_seeds_give_equal_drives():
    one, same, other = (simulate(ROOM, SQUARE, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.log.ranges, same.log.ranges)
    np.testing.assert_array_equal(one.log.odometry, same.log.odometry)
    assert not np.array_equal(one.log.odometry, other.log.odometry)


def test_a_slow_laser_distorts_scans_while_the_robot_turns():
    fast, slow = (simulate(ROOM, SQUARE, 1, sweep=sweep) for sweep in (0.0, 0.1))
    turning = np.flatnonzero(np.abs(relative(fast.true[:-1], fast.true[1:])[:, 2]) > 0.1) + 1
    difference = np.abs(fast.log.ranges[turning] - slow.log.ranges[turning])
    assert np.nanmax(difference) > 0.05
    np.testing.assert_array_equal(fast.log.ranges[0], slow.log.ranges[0])


def test_odometry_drifts():
    true = drive(SQUARE)[::4]
    found = odometry(true, np.random.default_rng(1))
    steps, told = relative(true[:-1], true[1:]), relative(found[:-1], found[1:])
    assert 1.01 < told[:, 0].sum() / steps[:, 0].sum() < 1.03
    assert np.abs(told[:, 2] - steps[:, 2]).max() > 0.005


def test_the_office_has_a_closed_ring_and_its_route_touches_nothing():
    walls, points = office(0), route()
    assert len(points) > 60
    np.testing.assert_allclose(points[0], points[-1])
    begin, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    for point in drive(points)[::10, :2]:
        place = np.clip(((point - begin) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
        assert np.hypot(*(begin + place[:, None] * along - point).T).min() > 0.3
