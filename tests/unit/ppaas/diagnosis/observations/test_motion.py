"""Commands and odometry over the same seconds."""

import math

import pytest

from ppaas.diagnosis.observations.recorder import LONGEST_COMMAND, Motion
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from tests.support.world.diagnosed_robot import DiagnosedRobot

ROBOT = DiagnosedRobot()


def twist(forward: float, turn: float) -> Twist:
    return Twist(Vector3(x=forward), Vector3(z=turn))


def test_commands_add_up_to_the_distance_that_odometry_shows() -> None:
    motion = Motion()
    for i in range(21):
        motion.command(twist(0.5, 0.2), i * 0.1)
        motion.odometry(ROBOT.odometry(Pose2D(0.05 * i, 0.0, 0.02 * i)), i * 0.1)
    facts = motion.facts(2.0)
    assert (facts.ordered, facts.ordered_turn) == (pytest.approx(1.0), pytest.approx(0.4))
    assert (facts.moved, facts.moved_turn) == (pytest.approx(1.0, rel=0.05), pytest.approx(0.4))
    assert facts.moved_path == pytest.approx(facts.ordered_path, rel=0.05)
    assert (facts.parent, facts.child, facts.commands) == ("odom", "base_link", 21)


def test_driving_backwards_has_a_negative_distance_and_a_positive_path() -> None:
    motion = Motion()
    for i in range(11):
        motion.odometry(ROBOT.odometry(Pose2D(-0.1 * i, 0.0, 0.0)), i * 0.1)
    facts = motion.facts(1.0)
    assert (facts.moved, facts.moved_path, facts.jump) == pytest.approx((-1.0, 1.0, 0.1))


def test_last_command_holds_for_half_a_second_only() -> None:
    motion = Motion()
    motion.command(twist(1.0, 0.0), 0.0)
    assert motion.facts(5.0).ordered == LONGEST_COMMAND
    assert motion.facts(60.0).commands == 0


def test_odometry_that_is_not_finite_is_left_out() -> None:
    motion = Motion()
    motion.odometry(ROBOT.odometry(Pose2D(math.nan, 0.0, 0.0)), 0.0)
    motion.odometry(ROBOT.odometry(Pose2D(1.0, 0.0, 0.0)), 0.1)
    assert motion.facts(0.1).moved_path == 0.0
