"""Recovery behaviours, and the collision check of motions that follow no plan."""

import math

import pytest

from ppaas.controllers.base import Velocity
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.geometry import Pose2D
from ppaas.recoveries import RecoveryFailed, create
from ppaas.recoveries.free_motion import is_free
from tests.support.world.recovering import MIDDLE, Run, room


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


BACK = Velocity(-0.2, 0.0)


def with_band(cost: int, x_from: float, x_to: float):
    costmap = room()
    costmap.data[:, round(x_from / 0.05) : round(x_to / 0.05)] = cost
    return costmap


@pytest.mark.parametrize("cost", [INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION])
def test_motion_through_inscribed_lethal_or_unknown_cells_is_blocked(cost):
    band = with_band(cost, 1.55, 1.6)
    assert is_free(band, MIDDLE, BACK, 1.9)
    assert not is_free(band, MIDDLE, BACK, 2.1)
    assert not is_free(band, MIDDLE, BACK, 60.0), "a wall that the motion passes through blocks it"
    assert is_free(band, MIDDLE, Velocity(0.2, 0.0), 5.0)


def test_costs_below_inscribed_are_free():
    assert is_free(with_band(INSCRIBED_INFLATED_OBSTACLE - 1, 0.0, 4.0), MIDDLE, BACK, 5.0)


def test_motion_beyond_the_costmap_is_blocked():
    assert is_free(room(), Pose2D(0.5, 2.0), BACK, 2.4)
    assert not is_free(room(), Pose2D(0.5, 2.0), BACK, 2.6)
    assert not is_free(room(), Pose2D(-1.0, 2.0), BACK, 0.1)


def test_turning_in_place_is_always_free():
    assert is_free(with_band(INSCRIBED_INFLATED_OBSTACLE, 0.0, 4.0), MIDDLE, Velocity(0.0, 1.0), 6.0)


def test_arc_motion_is_checked_along_the_arc():
    turning = Velocity(0.5, 0.5 * math.pi / 2)
    ahead = with_band(LETHAL_OBSTACLE, 3.1, 4.0)
    assert not is_free(ahead, MIDDLE, Velocity(0.5, 0.0), 2.5)
    assert is_free(ahead, MIDDLE, turning, 2.5)


@pytest.mark.parametrize(("back_to", "free"), [(1.95, True), (1.9, True), (1.85, False), (1.0, False)])
def test_robot_in_inscribed_cells_may_leave_them_soon(back_to, free):
    assert is_free(with_band(INSCRIBED_INFLATED_OBSTACLE, back_to, 4.0), Pose2D(2.0, 2.0), BACK, 1.0) is free


def test_short_motion_may_not_end_in_inscribed_cells():
    assert not is_free(with_band(INSCRIBED_INFLATED_OBSTACLE, 1.0, 4.0), MIDDLE, BACK, 0.1)


def test_robot_may_not_leave_through_lethal_cells():
    costmap = with_band(INSCRIBED_INFLATED_OBSTACLE, 1.9, 4.0)
    costmap.data[:, 38] = LETHAL_OBSTACLE
    assert not is_free(costmap, MIDDLE, BACK, 1.0)


def test_robot_turns_in_place_once_per_run():
    rotate = create("rotate_recovery")
    for _ in range(2):
        run = Run(rotate, pose=Pose2D(2.0, 2.0, 3.0))
        run.to_the_end()
        turned = sum(velocity.angular for velocity in run.velocities) * 0.1
        assert 2 * math.pi <= turned < 2 * math.pi + 0.2
        assert all(velocity.linear == 0.0 and 0.4 <= velocity.angular <= 1.0 for velocity in run.velocities)


def test_robot_that_does_not_turn_fails_after_the_patience():
    run = Run(create("rotate_recovery", rotation_patience=2.0))
    with pytest.raises(RecoveryFailed, match=r"6\.3 rad of the turn remained after 2 s"):
        run.to_the_end(moves=False)
    assert 20 <= len(run.velocities) <= 22


def test_robot_whose_outline_has_no_room_stops_turning_before_it_touches():
    """A robot that is longer than wide: an obstacle is at 1 rad to its left."""
    run = Run(create("rotate_recovery"))
    run.fits = lambda pose: pose.theta < 1.0
    with pytest.raises(RecoveryFailed, match="no room"):
        run.to_the_end()
    assert 0.3 < run.pose.theta < 0.6
    free = Run(create("rotate_recovery"))
    free.fits = lambda _: True
    free.to_the_end()


@pytest.mark.parametrize("turn", [1.57, -1.57, -7.0, 0.0])
def test_a_turn_of_any_angle_ends_there_and_goes_the_way_of_its_sign(turn):
    run = Run(create("nav2_behaviors/Spin", spin_dist=turn))
    run.to_the_end()
    turned = sum(velocity.angular for velocity in run.velocities) * 0.1
    assert turned == pytest.approx(turn, abs=0.1)
    assert all(velocity.angular * turn > 0.0 for velocity in run.velocities)


def test_only_the_turn_that_remains_has_to_be_free():
    run = Run(create("rotate_recovery", spin_dist=-0.3))
    run.fits = lambda pose: pose.theta > -0.5
    run.to_the_end()
    blocked = Run(create("rotate_recovery", spin_dist=-1.0))
    blocked.fits = run.fits
    with pytest.raises(RecoveryFailed, match="no room"):
        blocked.to_the_end()


@pytest.mark.parametrize(
    ("parameters", "area"),
    [
        ({}, (MIDDLE, 3.0, "both")),
        ({"reset_distance": 0.0}, (MIDDLE, 0.0, "both")),
        ({"affected_maps": "local", "layer_names": ["obstacle_layer"]}, (MIDDLE, 3.0, "local")),
    ],
)
def test_distant_obstacles_are_cleared_once_at_rest(parameters, area):
    run = Run(create("clear_costmap_recovery", **parameters))
    assert run.to_the_end() == 0.0
    assert run.cleared == [area]
    assert not run.velocities


def test_nothing_is_cleared_without_layers():
    run = Run(create("clear_costmap_recovery", layer_names=[]))
    run.to_the_end()
    assert not run.cleared


def test_robot_waits_for_the_given_duration():
    wait = create("wait", wait_duration=1.5)
    for _ in range(2):
        run = Run(wait)
        assert run.to_the_end() == pytest.approx(1.5, abs=0.11)
        assert set(run.velocities) == {Velocity()}
