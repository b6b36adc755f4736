"""Bags whose robot had no clock, or one that was set back; frames without names; scans that are left out."""

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace as Of
from typing import Any

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from robots.recordings.bag_times import MOST_PARTS, BagMessage
from robots.recordings.recording import RecordedFrames, Recording
from robots.recordings.ros_bags import ODOMETRY, SCAN, TRANSFORMS, recording_of

SECOND = 10**9


def header(stamp: float, frame: str) -> Any:
    sec, nanosec = divmod(round(stamp * SECOND), SECOND)
    return Of(stamp=Of(sec=sec, nanosec=nanosec), frame_id=frame)


def odometry(
    at: float,
    x: float,
    stamp: float,
    parent: str = "odom",
    child: str = "base_link",
    topic: str = "/odom",
    w: float = 1.0,
) -> BagMessage:
    pose = Of(position=Of(x=x, y=0.0, z=0.0), orientation=Of(x=0.0, y=0.0, z=0.0, w=w))
    message = Of(header=header(stamp, parent), child_frame_id=child, pose=Of(pose=pose))
    return BagMessage(topic, ODOMETRY, message, round(at * SECOND))


def scan(at: float, stamp: float, frame: str = "base_link", count: int = 5, topic: str = "/scan") -> BagMessage:
    fields = {"angle_min": 0.0, "angle_max": 0.4, "angle_increment": 0.1, "range_min": 0.1, "range_max": 8.0}
    message = Of(header=header(stamp, frame), ranges=np.full(count, 2.0, np.float32), **fields)
    return BagMessage(topic, SCAN, message, round(at * SECOND))


def drive(stamps: list[float], begin: float = 1000.0) -> Iterator[BagMessage]:
    """Yield a message of odometry and a scan each second, with these stamps; the robot is at x = 0, 1, 2, …."""
    for number, stamp in enumerate(stamps):
        yield odometry(begin + number, float(number), stamp)
        yield scan(begin + number, stamp)


def read(*messages: BagMessage, **names: str) -> Recording:
    return recording_of(messages, Path("drive.bag"), RecordedFrames(**names), lambda: "")


def xs(recording: Recording) -> list[float]:
    return [round(look.odom.x, 6) for look in recording.looks]


@pytest.mark.parametrize("stamp", [0.0, 77.5])
def test_messages_whose_stamps_are_all_the_same_have_the_times_of_recording(stamp: float) -> None:
    recording = read(*drive([stamp] * 4))
    assert xs(recording) == [0.0, 1.0, 2.0, 3.0]
    assert [look.stamp for look in recording.looks] == [1000.0, 1001.0, 1002.0, 1003.0]
    assert recording.notes == tuple(
        f"all stamps on {topic} are {stamp:g} s: the times of recording are used" for topic in ("/odom", "/scan")
    )


def test_scans_alone_may_be_without_stamps() -> None:
    moves = [odometry(1000.0 + at, at, 1000.0 + at) for at in (0.0, 1.0, 2.0)]
    recording = read(*moves, scan(1000.5, 0.0), scan(1001.5, 0.0))
    assert xs(recording) == [0.5, 1.5]


def transform(at: float, stamp: float, parent: str, child: str, x: float, topic: str = "/tf") -> BagMessage:
    moved = Of(translation=Of(x=x, y=0.0, z=0.0), rotation=Of(x=0.0, y=0.0, z=0.0, w=1.0))
    message = Of(transforms=[Of(header=header(stamp, parent), child_frame_id=child, transform=moved)])
    return BagMessage(topic, TRANSFORMS[0], message, round(at * SECOND))


def test_transforms_without_stamps_have_the_times_of_recording_and_static_ones_none() -> None:
    moves = [transform(1000.0 + at, 0.0, "odom", "base_link", at) for at in (0.0, 1.0, 2.0)]
    recording = read(
        transform(1002.0, 0.0, "base_link", "laser", 0.2, "/tf_static"),
        *moves,
        scan(1000.5, 1000.5, "laser"),
        scan(1001.5, 1001.5, "laser"),
    )
    assert xs(recording) == [0.5, 1.5]
    assert recording.looks[0].laser == Pose2D(0.2, 0.0)
    assert recording.notes == ("all stamps on /tf are 0 s: the times of recording are used",)


@pytest.mark.parametrize("laser", [34.0, 9000.0])
def test_scans_and_odometry_by_two_clocks_have_the_times_of_recording(laser: float) -> None:
    moves = [odometry(1000.0 + at, at, 1000.0 + at) for at in (0.0, 1.0, 2.0)]
    recording = read(*moves, scan(1000.5, laser), scan(1001.5, laser + 1.0))
    assert xs(recording) == [0.5, 1.5]
    (note,) = recording.notes
    assert note.startswith(
        f"scans are stamped {laser} to {laser + 1.0} s, and odometry and transforms 1000.0 to 1002.0 s"
    )
    with pytest.raises(InvalidInput, match="set one clock where it is recorded"):
        read(*(message._replace(recorded=0) for message in moves), scan(1000.5, laser)._replace(recorded=0))


def test_scans_a_little_before_the_odometry_keep_their_stamps() -> None:
    moves = [odometry(1000.0 + at, at, 1000.0 + at) for at in (0.0, 1.0)]
    with pytest.raises(InvalidInput, match="no odometry"):
        read(*moves, scan(1000.5, 950.0), scan(1000.6, 951.0))


def test_one_message_with_a_stamp_keeps_it() -> None:
    recording = read(*drive([5.0, 6.0]), scan(1009.0, 5.5, topic="/rear"))
    assert [look.stamp for look in recording.looks] == [5.0, 5.5, 6.0]


def test_of_parts_that_overlap_since_the_clock_was_set_back_the_one_with_most_scans_counts() -> None:
    """As after a loop of ``rosbag play``, a reset of a simulation, or a correction of the clock."""
    recording = read(*drive([10.0, 11.0, 12.0, 13.0, 10.5, 11.5, 12.5]))
    assert xs(recording) == [0.0, 1.0, 2.0, 3.0]
    (note,) = recording.notes
    assert note.startswith("the robot's clock was set back in the bag: of 2 parts, 1 with most scans")
    assert note.endswith("are used: 4 of 7")


def test_parts_whose_times_do_not_overlap_are_all_used() -> None:
    """As after a start at 1970, or of files whose order is another one."""
    recording = read(*drive([900.0, 901.0, 902.0, 5.0, 6.0, 7.0]))
    assert sorted(xs(recording)) == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert recording.notes == ()


def test_messages_in_disorder_are_sorted_by_their_stamps() -> None:
    stamps = [float(9 * number % 29) for number in range(29)]
    assert sum(after < before - 1.0 for before, after in pairwise(stamps)) > MOST_PARTS
    recording = read(*drive(stamps))
    assert [look.stamp for look in recording.looks] == sorted(stamps)
    assert xs(recording) == [float(stamps.index(stamp)) for stamp in sorted(stamps)]


@pytest.mark.parametrize(
    ("parent", "child"),
    [("odom", ""), ("", ""), ("odom", "odom"), ("/odom", "odom"), ("base_link", "base_link"), ("", "base_link")],
)
def test_odometry_without_names_of_frames_is_that_of_the_robot(parent: str, child: str) -> None:
    moves = [odometry(1000.0 + at, at, 1000.0 + at, parent, child) for at in (0.0, 1.0)]
    recording = read(*moves, scan(1000.5, 1000.5))
    assert (recording.has_odometry, xs(recording)) == (True, [0.5])


def test_odometry_of_which_every_rotation_is_zero_is_refused_with_the_reason() -> None:
    moves = [odometry(1000.0 + at, at, 1000.0 + at, w=0.0) for at in (0.0, 1.0)]
    with pytest.raises(InvalidInput, match=r"no odometry that can be used: .*the zero quaternion"):
        read(*moves, scan(1000.5, 1000.5))
    recording = read(*moves, *drive([1000.0, 1001.0]))
    assert recording.notes[0].startswith("2 transforms or poses of odometry left out; the first: ")


def test_odometry_that_is_not_used_is_named() -> None:
    filtered = [odometry(1000.0 + at, 9.0, 1000.0 + at, topic="/odometry/filtered") for at in (0.0, 1.0)]
    recording = read(*drive([1000.0, 1001.0]), *filtered)
    assert xs(recording) == [0.0, 1.0]
    assert recording.notes == ("odometry on /odom is used, that on /odometry/filtered is not",)


def test_a_laser_without_a_place_is_named() -> None:
    recording = read(*drive([1000.0, 1001.0]), scan(1000.5, 1000.5, "rear"))
    assert recording.notes == (
        "no transform leads from base_link to the laser rear: it is taken to be there, and to look ahead",
    )


def test_scans_that_are_left_out_are_counted_with_the_reason() -> None:
    late = [scan(1002.0 + at, 1002.0 + at) for at in (0.0, 1.0)]
    recording = read(*drive([1000.0, 1001.0]), scan(1000.5, 1000.5, count=11), scan(1000.0, 1000.0), *late)
    assert xs(recording) == [0.0, 1.0]
    assert recording.notes[:2] == (
        "2 of 6 scans left out: there is no odometry at their time",
        "1 of 6 scans left out: they have frame and stamp of another one",
    )
    assert recording.notes[2].startswith("1 of 6 scans left out: a scan ")


def test_a_few_scans_before_the_first_odometry_are_not_worth_a_note() -> None:
    recording = read(scan(999.0, 999.0), *drive([1000.0 + number for number in range(60)]))
    assert (len(recording.looks), recording.notes) == (60, ())
    assert math.isclose(recording.looks[0].stamp, 1000.0)


def test_odometry_without_a_name_of_the_robot_is_that_of_the_frame_above_its_others() -> None:
    """As a URDF with base_footprint has it."""
    joints = [("base_footprint", "base_link", 0.0), ("base_link", "laser", 0.1)]
    static = [transform(1000.0, 1000.0, *joint, topic="/tf_static") for joint in joints]
    moves = [odometry(1000.0 + at, at, 1000.0 + at, child="") for at in (0.0, 1.0, 2.0)]
    recording = read(*static, *moves, scan(1000.5, 1000.5, "laser"), scan(1001.5, 1001.5, "laser"))
    assert (xs(recording), recording.notes) == ([0.5, 1.5], ())
    assert recording.looks[0].laser == Pose2D(0.1, 0.0)


@pytest.mark.parametrize("other", ["wheel_odom", "map", "vicon"])
@pytest.mark.parametrize("first", [True, False])
def test_of_two_parents_that_take_turns_the_odometry_counts(other: str, first: bool) -> None:
    """As of wheels and a filter that both publish transforms, or of a tracking system beside the odometry."""
    moves = []
    for at in (0.0, 1.0, 2.0):
        both = [("odom", at), (other, 70.0)]
        moves += [transform(1000.0 + at, 1000.0 + at, one, "base_link", x) for one, x in both[:: 1 if first else -1]]
    scans = scan(1000.5, 1000.5), scan(1001.5, 1001.5)
    recording = read(*moves, *scans)
    assert xs(recording) == [0.5, 1.5]
    assert recording.notes == (f"transforms of base_link in odom are used, those in {other} are not",)
    assert xs(read(*moves, *scans, odom=other)) == [70.0, 70.0]


def test_scans_of_several_robots_are_refused() -> None:
    ends = [(at, robot) for at in (0.0, 1.0) for robot in "ab"]
    moves = [transform(1000.0 + at, 1000.0 + at, f"{one}/odom", f"{one}/base_link", at) for at, one in ends]
    scans = [scan(1000.5, 1000.5, f"{one}/base_link", topic=f"/{one}/scan") for one in "ab"]
    text = "scans of several robots: no transform leads from a/base_link to b/base_link"
    with pytest.raises(InvalidInput, match=text):
        read(*moves, *scans)
    with pytest.raises(InvalidInput, match=text):
        read(*moves, *scans, scan_topic="/b/scan")
    assert xs(read(*moves, *scans, scan_topic="/b/scan", base="b/base_link")) == [0.5]
