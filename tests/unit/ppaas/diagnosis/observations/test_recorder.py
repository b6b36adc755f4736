"""Motion and frames of a robot as the recorder hears them."""

import math

import pytest

from ppaas.diagnosis.observations.place import WatchedRobot
from ppaas.diagnosis.observations.recorder import (
    LONGEST_COMMAND,
    MOST_PARENTS,
    FrameWatch,
    Motion,
    ObservationRecorder,
    alternates,
)
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import TransformStamped, Twist, Vector3
from ppaas.messages.health.stops import StopState
from ppaas.messages.operators.teleoperation import TeleopState
from ppaas.transforms.planar import transform_message
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


def transform(parent: str, child: str, x: float = 0.0) -> TransformStamped:
    return transform_message(parent, child, Pose2D(x, 0.0, 0.0), Time())


def test_last_parent_of_a_frame_is_the_last_of_its_parents_and_given_up_ones_expire() -> None:
    watch = FrameWatch()
    watch.hear([transform("odom", "base_link")], 0.0, static=False)
    watch.hear([transform("odom_combined", "/base_link")], 1.0, static=False)
    [frame] = watch.facts(2.0)
    assert (frame.name, frame.parents, frame.silence) == ("base_link", ("odom", "odom_combined"), 1.0)
    assert watch.facts(60.0)[0].parents == ("odom_combined",)


def test_number_of_parents_is_bounded() -> None:
    watch = FrameWatch()
    for number in range(50):
        watch.hear([transform(f"p{number}", "base_link")], 0.0, static=True)
    assert len(watch.facts(0.0)[0].parents) == MOST_PARENTS


def test_people_are_no_frames_of_the_robot() -> None:
    watch = FrameWatch()
    watch.hear([transform("map", "tb1/torso_3"), transform("map", "tb1/laser")], 0.0, static=False)
    assert [frame.name for frame in watch.facts(0.0)] == ["tb1/laser"]


def test_two_senders_that_take_turns_are_told_from_one_that_drives() -> None:
    turns = [(0.01 * i + (i % 2) * 2.0, 0.0) for i in range(20)]
    drives = [(0.1 * i, 0.0) for i in range(20)]
    assert [alternates(turns), alternates(drives), alternates([(0.0, 0.0)] * 20), alternates(turns[:5])] == [
        True, False, False, False,
    ]  # fmt: skip


def test_a_stop_holds_until_it_is_released_and_a_driver_as_long_as_states_come() -> None:
    recorder = ObservationRecorder(0.0)
    recorder.take("stop/state", StopState(stopped=True, text="stopped by 'ann'"), 1.0, 0.0)
    recorder.take("teleop_state", TeleopState(Header(), 7, id="x", driver="bob", mode="locked", text="late"), 1.0, 0.0)
    seen = recorder.observations(1.5, WatchedRobot())
    assert (seen.stopped, seen.hand.driver, seen.hand.mode, seen.hand.text) == (
        "stopped by 'ann'",
        "bob",
        "locked",
        "late",
    )
    seen = recorder.observations(3.0, WatchedRobot())
    assert (seen.stopped, seen.hand.driver) == ("stopped by 'ann'", "")
    recorder.take("stop/state", StopState(), 3.0, 0.0)
    recorder.take("teleop_state", TeleopState(Header(), 8, mode="free"), 3.0, 0.0)
    seen = recorder.observations(3.0, WatchedRobot())
    assert (seen.stopped, seen.hand.driver) == ("", "")
