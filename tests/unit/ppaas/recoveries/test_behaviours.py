"""Each behaviour, by what it does to a robot."""

import math

import pytest

from ppaas.controllers.base import Velocity
from ppaas.costmap.costmap import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE
from ppaas.geometry import Pose2D
from ppaas.recoveries import RecoveryFailed, create
from tests.support.world.recovering import MIDDLE, Run, room

# -- clear_costmap_recovery --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameters", "area"),
    [
        ({}, (MIDDLE, 3.0, "both")),
        ({"reset_distance": 0.0}, (MIDDLE, 0.0, "both")),
        ({"affected_maps": "local", "layer_names": ["obstacle_layer"]}, (MIDDLE, 3.0, "local")),
    ],
)
def test_what_is_far_is_forgotten_once_and_the_robot_stands(parameters, area):
    run = Run(create("clear_costmap_recovery", **parameters))
    assert run.to_the_end() == 0.0
    assert run.cleared == [area]
    assert not run.velocities


def test_without_layers_nothing_is_forgotten():
    run = Run(create("clear_costmap_recovery", layer_names=[]))
    run.to_the_end()
    assert not run.cleared


# -- rotate_recovery ---------------------------------------------------------------------------------------------------


def test_the_robot_turns_once_round_on_the_spot_as_often_as_it_is_asked_to():
    rotate = create("rotate_recovery")
    for _ in range(2):
        run = Run(rotate, pose=Pose2D(2.0, 2.0, 3.0))
        run.to_the_end()
        turned = sum(velocity.angular for velocity in run.velocities) * 0.1
        assert 2 * math.pi <= turned < 2 * math.pi + 0.2
        assert all(velocity.linear == 0.0 and 0.4 <= velocity.angular <= 1.0 for velocity in run.velocities)


def test_a_robot_that_does_not_turn_is_given_up():
    run = Run(create("rotate_recovery", rotation_patience=2.0))
    with pytest.raises(RecoveryFailed, match=r"6\.3 rad of the turn were left after 2 s"):
        run.to_the_end(moves=False)
    assert 20 <= len(run.velocities) <= 22


# -- back_up -----------------------------------------------------------------------------------------------------------


def test_the_robot_backs_up_as_far_and_as_fast_as_it_is_told():
    run = Run(create("back_up", backup_dist=0.4, backup_speed=0.2), pose=Pose2D(2.0, 2.0, math.pi / 2))
    assert run.to_the_end() == pytest.approx(2.0, abs=0.1)
    assert set(run.velocities) == {Velocity(-0.2, 0.0)}
    assert run.pose.x == pytest.approx(2.0)
    assert 1.55 <= run.pose.y <= 1.601


def wall(x_from: float, x_to: float, cost: int, costmap=None):
    costmap = costmap or room()
    costmap.data[:, round(x_from / 0.05) : round(x_to / 0.05)] = cost
    return costmap


def test_a_way_back_that_is_not_free_is_not_taken():
    run = Run(create("back_up"), wall(1.6, 1.85, INSCRIBED_INFLATED_OBSTACLE))
    with pytest.raises(RecoveryFailed, match=r"not free after 0\.00 m of 0\.3 m"):
        run.cycle()


def test_what_comes_into_the_way_back_stops_it():
    run = Run(create("back_up"))
    run.cycle()
    wall(1.5, 1.8, LETHAL_OBSTACLE, run.costmap)
    with pytest.raises(RecoveryFailed, match=r"not free after 0\.0[12] m"):
        run.cycle()


def test_what_lies_beyond_its_distance_does_not_matter():
    run = Run(create("back_up", simulate_ahead_time=60.0), wall(1.0, 1.6, LETHAL_OBSTACLE))
    run.to_the_end()
    assert run.pose.x < 1.701


def test_a_robot_that_does_not_get_back_gives_up():
    run = Run(create("back_up", time_allowance=1.0))
    with pytest.raises(RecoveryFailed, match=r"backed up 0\.00 m of 0\.3 m in 1 s"):
        run.to_the_end(moves=False)


# -- wait --------------------------------------------------------------------------------------------------------------


def test_the_robot_stands_for_as_long_as_it_is_told():
    wait = create("wait", wait_duration=1.5)
    for _ in range(2):
        run = Run(wait)
        assert run.to_the_end() == pytest.approx(1.5, abs=0.11)
        assert set(run.velocities) == {Velocity()}
