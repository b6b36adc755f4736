import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.recoveries import RecoveryFailed, create
from tests.support.world.recovering import Run


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
