import numpy as np
import pytest

from ppaas.controllers.base import ControlRequest, Velocity
from ppaas.controllers.dwa.parameters import DwaParameters
from ppaas.controllers.dwa.rollouts import Rollouts
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.footprints import body_of
from ppaas.geometry import Pose2D, poses_along
from tests.support.world import grids

STANDING = Velocity()
PATH = poses_along(np.stack((np.arange(0.0, 4.0, 0.05), np.full(80, 1.0)), axis=1))


def rollouts(data, pose=Pose2D(1.0, 1.0), velocity=STANDING, **parameters):
    path = FollowedPath(PATH)
    path.locate(pose)
    request = ControlRequest(pose, velocity, grids.of(data, 0.05))
    p = DwaParameters(**parameters)
    return Rollouts(p, body_of(p.footprint, p.robot_radius), path, request, velocity)


def open_ground():
    return np.zeros((40, 80), np.uint8)


def test_in_the_open_the_best_is_straight_ahead_at_full_acceleration():
    assert rollouts(open_ground()).best() == pytest.approx((0.1, 0.0))
    assert rollouts(open_ground(), velocity=Velocity(0.45, 0.0)).best() == pytest.approx((0.5, 0.0))


def test_where_the_cost_is_high_it_slows_down():
    graded = np.full((40, 80), 200, np.uint8)
    assert rollouts(graded, velocity=Velocity(0.5, 0.0)).best().linear == pytest.approx(0.4)


def test_near_the_goal_it_slows_down():
    assert rollouts(open_ground(), Pose2D(3.9, 1.0), Velocity(0.5, 0.0)).best().linear == pytest.approx(0.4)


def test_close_to_a_wall_there_is_nothing_best_and_nowhere_to_turn():
    wall = open_ground()
    wall[:, 21:] = 254
    facing = rollouts(wall, Pose2D(1.045, 1.0))
    assert facing.best() is None
    assert facing.turn_to_free(0.0) is None


def test_before_a_slanting_wall_it_finds_the_heading_that_is_free():
    walls = np.fromfunction(lambda row, column: column > row, (40, 80))
    turn = rollouts(np.where(walls, 254, 0).astype(np.uint8)).turn_to_free(0.0)
    assert 0.6 < turn < 1.1


def test_only_headings_that_lead_on_are_tried():
    wall = open_ground()
    wall[:, 21:] = 254
    near = rollouts(wall, Pose2D(1.03, 1.0))
    assert near.turn_to_free(0.0) is None
    assert 0.5 < near.turn_to_free(1.5) < 2.6


LONG = ((0.5, 0.12), (-0.5, 0.12), (-0.5, -0.12), (0.5, -0.12))


def test_an_outline_goes_on_beside_a_wall_that_its_disc_would_touch_but_does_not_turn_there():
    corridor = open_ground()
    corridor[:16] = corridor[24:] = 254
    corridor[16:24] = 253
    beside = rollouts(corridor, velocity=Velocity(0.3, 0.0), footprint=LONG)
    assert beside.best().linear > 0.2
    assert not beside.can_turn(1.5)
    assert rollouts(corridor, velocity=Velocity(0.3, 0.0)).can_turn(1.5)
    assert rollouts(open_ground(), footprint=LONG).can_turn(1.5)
