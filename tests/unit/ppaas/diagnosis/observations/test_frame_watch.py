"""Frames of a robot: parents, senders, and people that are left out."""

from ppaas.diagnosis.observations.recorder import MOST_PARENTS, FrameWatch, alternates
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.transforms.planar import transform_message


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
