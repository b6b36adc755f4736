"""Progress of a robot towards places."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.people.following.following import FORGOTTEN, STUCK, Progress

PLACE = Pose2D(5.0, 0.0)


def test_robot_that_stands_before_a_place_is_stuck_after_a_while_and_the_place_is_avoided_for_a_time():
    progress = Progress()
    assert not progress.is_stuck(0.0, Pose2D(0.0, 0.0), PLACE)
    assert not progress.is_stuck(STUCK, Pose2D(0.1, 0.0), PLACE)
    assert progress.is_stuck(STUCK + 0.5, Pose2D(0.1, 0.0), PLACE)
    assert progress.failed(STUCK + 1.0).tolist() == [[5.0, 0.0]] and progress.failures == 1
    assert not len(progress.failed(STUCK + 1.0 + FORGOTTEN))


def test_robot_that_moves_or_has_arrived_is_not_stuck():
    progress = Progress()
    for second in range(30):
        assert not progress.is_stuck(float(second), Pose2D(0.1 * second, 0.0), PLACE)
    arrived = Progress()
    assert not any(arrived.is_stuck(float(second), Pose2D(4.9, 0.0), PLACE) for second in range(30))


@pytest.mark.parametrize("pauses", [True, False])
def test_time_counts_anew_for_another_place_and_after_a_rest(pauses):
    progress, here = Progress(), Pose2D(0.0, 0.0)
    progress.is_stuck(0.0, here, PLACE)
    if pauses:
        progress.rest()
    other = PLACE if pauses else Pose2D(0.0, 5.0)
    assert not progress.is_stuck(STUCK + 1.0, here, other)
    assert not progress.is_stuck(2.0 * STUCK, here, other)


def test_failures_are_forgotten_where_the_robot_stands_well():
    progress = Progress()
    assert [progress.fail(0.0), progress.fail(0.0)] == [1, 2]
    progress.reset()
    assert progress.fail(0.0) == 1
