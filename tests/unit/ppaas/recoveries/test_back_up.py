import math

import pytest

from ppaas.controllers.base import Velocity
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE
from ppaas.geometry import Pose2D
from ppaas.recoveries import RecoveryFailed, create
from tests.support.world.recovering import Run, room


def test_robot_backs_up_by_the_given_distance_and_speed():
    run = Run(create("back_up", backup_dist=0.4, backup_speed=0.2), pose=Pose2D(2.0, 2.0, math.pi / 2))
    assert run.to_the_end() == pytest.approx(2.0, abs=0.1)
    assert set(run.velocities) == {Velocity(-0.2, 0.0)}
    assert run.pose.x == pytest.approx(2.0)
    assert 1.55 <= run.pose.y <= 1.601


def wall(x_from: float, x_to: float, cost: int, costmap=None):
    costmap = costmap or room()
    costmap.data[:, round(x_from / 0.05) : round(x_to / 0.05)] = cost
    return costmap


def test_blocked_way_back_fails_at_once():
    run = Run(create("back_up"), wall(1.6, 1.85, INSCRIBED_INFLATED_OBSTACLE))
    with pytest.raises(RecoveryFailed, match=r"not free after 0\.00 m of 0\.3 m"):
        run.cycle()


def test_obstacle_that_appears_behind_stops_the_robot():
    run = Run(create("back_up"))
    run.cycle()
    wall(1.5, 1.8, LETHAL_OBSTACLE, run.costmap)
    with pytest.raises(RecoveryFailed, match=r"not free after 0\.0[12] m"):
        run.cycle()


def test_obstacle_beyond_the_distance_is_ignored():
    run = Run(create("back_up", simulate_ahead_time=60.0), wall(1.0, 1.6, LETHAL_OBSTACLE))
    run.to_the_end()
    assert run.pose.x < 1.701


def test_robot_that_does_not_move_fails_after_the_time_allowance():
    run = Run(create("back_up", time_allowance=1.0))
    with pytest.raises(RecoveryFailed, match=r"backed up only 0\.00 m of 0\.3 m in 1 s"):
        run.to_the_end(moves=False)


def test_outline_of_the_robot_is_checked_behind_it():
    run = Run(create("back_up"))
    run.fits = lambda pose: pose.x > 1.85
    with pytest.raises(RecoveryFailed, match="not free"):
        run.to_the_end()
    assert run.pose.x > 1.85
