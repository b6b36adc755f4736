"""Odometry since a checkpoint: a robot that has driven is told from odometry that was reset."""

import pytest

from ppaas.nodes.amcl.continuity import FASTEST, LONGEST_GAP, SLACK, has_driven


@pytest.mark.parametrize(
    ("metres", "seconds", "expected"),
    [
        (LONGEST_GAP, None, True),
        (LONGEST_GAP, 0.0, True),
        (LONGEST_GAP + 0.1, None, False),
        (LONGEST_GAP + 0.1, -60.0, False),
        (SLACK + 20.0 * FASTEST, 20.0, True),
        (SLACK + 20.0 * FASTEST + 0.1, 20.0, False),
    ],
)
def test_a_robot_has_driven_as_far_as_it_can_in_the_time(metres, seconds, expected):
    assert has_driven(metres, seconds) == expected
