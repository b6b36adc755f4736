import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import ControlRequest, Velocity
from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.dwa import DwaParameters, Rollouts, window
from ppaas.controllers.followed_path import FollowedPath
from ppaas.geometry import Pose2D, poses_along
from tests.support.world import grids

LIMITS = DwaParameters()
STANDING = Velocity()
PATH = poses_along(np.stack((np.arange(0.0, 4.0, 0.05), np.full(80, 1.0)), axis=1))


def rollouts(data, pose=Pose2D(1.0, 1.0), velocity=STANDING, **parameters):
    path = FollowedPath(PATH)
    path.locate(pose)
    request = ControlRequest(pose, velocity, grids.of(data, 0.05))
    p = DwaParameters(**parameters)
    return Rollouts(p, body_of(p.footprint, p.robot_radius), path, request, velocity)


def free_space():
    return np.zeros((40, 80), np.uint8)


def test_free_space_allows_full_acceleration_straight_ahead():
    assert rollouts(free_space()).best() == pytest.approx((0.1, 0.0))
    assert rollouts(free_space(), velocity=Velocity(0.45, 0.0)).best() == pytest.approx((0.5, 0.0))


def test_high_costs_reduce_the_speed():
    graded = np.full((40, 80), 200, np.uint8)
    assert rollouts(graded, velocity=Velocity(0.5, 0.0)).best().linear == pytest.approx(0.4)


def test_speed_is_reduced_near_the_goal():
    assert rollouts(free_space(), Pose2D(3.9, 1.0), Velocity(0.5, 0.0)).best().linear == pytest.approx(0.4)


def test_no_velocity_or_turn_is_found_close_to_a_wall():
    wall = free_space()
    wall[:, 21:] = 254
    facing = rollouts(wall, Pose2D(1.045, 1.0))
    assert facing.best() is None
    assert facing.turn_to_free(0.0) is None


def test_turn_to_free_finds_the_free_heading_at_a_slanted_wall():
    walls = np.fromfunction(lambda row, column: column > row, (40, 80))
    turn = rollouts(np.where(walls, 254, 0).astype(np.uint8)).turn_to_free(0.0)
    assert 0.6 < turn < 1.1


def test_turn_to_free_tries_headings_near_the_path_only():
    wall = free_space()
    wall[:, 21:] = 254
    near = rollouts(wall, Pose2D(1.03, 1.0))
    assert near.turn_to_free(0.0) is None
    assert 0.5 < near.turn_to_free(1.5) < 2.6


LONG = ((0.5, 0.12), (-0.5, 0.12), (-0.5, -0.12), (0.5, -0.12))


def test_footprint_drives_along_a_wall_but_cannot_turn_there():
    corridor = free_space()
    corridor[:16] = corridor[24:] = 254
    corridor[16:24] = 253
    beside = rollouts(corridor, velocity=Velocity(0.3, 0.0), footprint=LONG)
    assert beside.best().linear > 0.2
    assert not beside.can_turn(1.5)
    assert rollouts(corridor, velocity=Velocity(0.3, 0.0)).can_turn(1.5)
    assert rollouts(free_space(), footprint=LONG).can_turn(1.5)


@given(st.builds(Velocity, st.floats(0.0, 0.5), st.floats(-1.5, 1.5)), st.floats(0.0, 0.5), st.floats(0.02, 0.2))
def test_window_obeys_acceleration_and_velocity_limits(velocity, fastest, period):
    linear, angular = window(velocity, fastest, LIMITS, period).T
    reach = LIMITS.acc_lim_x * period
    slow = np.abs(linear) == LIMITS.min_vel_trans
    assert np.all((np.abs(linear - velocity.linear) <= reach + 1e-9) | slow)
    assert np.all(np.abs(angular - velocity.angular) <= LIMITS.acc_lim_theta * period + 1e-9)
    assert np.all((linear >= LIMITS.min_vel_trans) & (linear <= LIMITS.max_vel_x))
    assert np.all(np.abs(angular) <= LIMITS.max_vel_theta)
    assert linear.max() <= max(fastest, velocity.linear - reach, LIMITS.min_vel_trans) + 1e-9


def test_window_of_a_slow_base_has_the_minimum_speed_only():
    weak = DwaParameters(acc_lim_x=0.1)
    assert set(window(Velocity(), 0.5, weak, 0.1)[:, 0]) == {weak.min_vel_trans}


def test_window_includes_driving_straight():
    assert 0.0 in window(Velocity(0.2, 0.05), 0.5, LIMITS, 0.1)[:, 1]


def test_window_includes_reversing_only_if_allowed():
    assert window(Velocity(), 0.5, LIMITS, 0.1)[:, 0].min() > 0.0
    assert window(Velocity(), 0.5, DwaParameters(min_vel_x=-0.2), 0.1)[:, 0].min() == pytest.approx(-0.1)
