"""Bags of ROS."""

import math
import sys
from pathlib import Path
from types import SimpleNamespace as Of
from typing import Any

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from robots.recordings.reader import read_recording
from robots.recordings.recording import Look, RecordedFrames, Recording
from robots.recordings.ros_bags import ECHOES, NO_ODOMETRY, ODOMETRY, SCAN, TRANSFORMS, BagMessage, recording_of

BAG = Path("drive.bag")


def header(seconds: float, frame: str) -> Any:
    whole = math.floor(seconds)
    return Of(stamp=Of(sec=whole, nanosec=round(1e9 * (seconds - whole))), frame_id=frame)


def turned(theta: float) -> Any:
    return Of(x=0.0, y=0.0, z=math.sin(theta / 2), w=math.cos(theta / 2))


def tf(
    seconds: float, parent: str, child: str, pose: Pose2D, rotation: Any = None, topic: str = "/tf", kind: int = 0
) -> BagMessage:
    moved = Of(translation=Of(x=pose.x, y=pose.y, z=0.3), rotation=rotation or turned(pose.theta))
    message = Of(transforms=[Of(header=header(seconds, parent), child_frame_id=child, transform=moved)])
    return BagMessage(topic, TRANSFORMS[kind], message)


def odometry(
    seconds: float, x: float, parent: str = "odom", child: str = "base_footprint", topic: str = "/odom"
) -> BagMessage:
    pose = Of(position=Of(x=x, y=0.0, z=0.0), orientation=turned(0.0))
    return BagMessage(topic, ODOMETRY, Of(header=header(seconds, parent), child_frame_id=child, pose=Of(pose=pose)))


def scan(seconds: float, count: int = 5, frame: str = "/laser", topic: str = "/scan") -> BagMessage:
    fields = {"angle_min": 0.0, "angle_max": 0.4, "angle_increment": 0.1, "range_min": 0.1, "range_max": 8.0}
    ranges = np.full(count, 2.0, np.float32)
    return BagMessage(topic, SCAN, Of(header=header(seconds, frame), ranges=ranges, **fields))


def looks_of(*messages: BagMessage, **names: str) -> tuple[Look, ...]:
    return recorded(*messages, **names).looks


def recorded(*messages: BagMessage, **names: str) -> Recording:
    return recording_of(messages, BAG, RecordedFrames(**names), lambda: "/scan_front, /scan_rear")


DRIVE = (odometry(1.0, 0.0), odometry(2.0, 1.0))


def test_odometry_is_interpolated_at_the_time_of_a_scan() -> None:
    (look,) = looks_of(odometry(1.0, 0.0), scan(0.5), scan(1.5), odometry(2.0, 1.0), scan(3.0))
    assert (look.stamp, look.true) == (1.5, None)
    assert look.odom.distance_to(Pose2D(0.5, 0.0)) < 1e-9
    assert look.scan.ranges == [2.0] * 5


def test_transforms_provide_odometry_laser_pose_and_true_pose() -> None:
    sideways = Of(x=math.sqrt(0.5), y=0.0, z=0.0, w=math.sqrt(0.5))
    joints = [
        message
        for at in (1.0, 2.0)
        for message in (
            tf(at, "/map", "/odom", Pose2D(5.0, 0.0, math.pi / 2)),
            tf(at, "odom", "base_footprint", Pose2D(1.0, 0.0)),
            tf(at, "base_footprint", "base_link", Pose2D(0.0, 0.0)),
            tf(at, "base_link", "laser", Pose2D(0.2, 0.1)),
            tf(at, "laser", "optical", Pose2D(0.0, 0.0), sideways),
        )
    ]
    (look,) = looks_of(*joints, odometry(1.0, 9.0), odometry(2.0, 9.0), scan(1.5))
    assert look.odom == Pose2D(1.0, 0.0)
    assert look.true is not None
    assert look.true.distance_to(Pose2D(5.0, 1.0)) < 1e-9
    assert look.laser == Pose2D(0.2, 0.1)


def test_a_bag_without_odometry_for_any_scan_is_refused() -> None:
    with pytest.raises(
        InvalidInput, match=r"1 scans, but no odometry .* at the time of any of them.*base_footprint, odom"
    ):
        looks_of(odometry(1.0, 0.0), scan(30.0))


def test_a_scan_of_wrong_size_is_left_out_unless_all_are() -> None:
    assert len(looks_of(*DRIVE, scan(1.5, count=11), scan(1.6))) == 1
    with pytest.raises(InvalidInput, match="ranges, not 11"):
        looks_of(*DRIVE, scan(1.5, count=11))


@pytest.mark.parametrize("at", [0.0, 1.5, 99.0])
def test_transforms_on_tf_static_hold_at_all_times(at: float) -> None:
    """As robot_state_publisher sends them: once, with the stamp of its start, or of the recorder's."""
    static = (
        tf(at, "base_footprint", "base_link", Pose2D(0.1, 0.0), topic="/tf_static"),
        tf(at, "base_link", "laser", Pose2D(0.2, 0.1), topic="tf_static"),
    )
    looks = looks_of(*static, *DRIVE, scan(1.2), scan(1.8))
    assert [look.stamp for look in looks] == [1.2, 1.8]
    for look in looks:
        # The robot is driven in base_link, 10 cm ahead of the frame of its odometry.
        assert look.laser.distance_to(Pose2D(0.2, 0.1)) < 1e-9
        assert look.odom.x == pytest.approx(look.stamp - 1.0 + 0.1)


def test_transforms_of_the_first_tf_are_read() -> None:
    moves = [tf(at, "odom", "base_link", Pose2D(at, 0.0), kind=1) for at in (1.0, 2.0)]
    (look,) = looks_of(*moves, scan(1.5))
    assert look.odom.x == pytest.approx(1.5)


@pytest.mark.parametrize("rotation", [Of(x=0.0, y=0.0, z=0.0, w=0.0), Of(x=0.0, y=0.0, z=math.nan, w=1.0)])
def test_a_transform_that_is_not_rigid_is_left_out(rotation: Any) -> None:
    """As tf2 does. Others are too: without a name, that close a loop."""
    broken = [tf(1.0, "base_footprint", "camera", Pose2D(0.0, 0.0), rotation, topic="/tf_static")]
    broken += [tf(1.0, "", "arm", Pose2D(0.0, 0.0)), tf(1.0, "arm", "arm", Pose2D(0.0, 0.0))]
    assert len(looks_of(*broken, *DRIVE, scan(1.5))) == 1


def test_each_scan_has_the_place_of_its_own_laser() -> None:
    back = Of(x=1.0, y=0.0, z=0.0, w=0.0)  # upside down
    lasers = (
        tf(0.0, "base_footprint", "front", Pose2D(0.3, 0.0), topic="/tf_static"),
        tf(0.0, "base_footprint", "rear", Pose2D(-0.3, 0.0, math.pi), topic="/tf_static"),
        tf(0.0, "front", "hanging", Pose2D(0.0, 0.0), back, topic="/tf_static"),
    )
    seen = [("front", 1.5), ("rear", 1.5), ("hanging", 1.6), ("unknown", 1.7)]
    scans = [scan(at, frame=frame, topic=f"/scan_{frame}") for frame, at in seen]
    looks = looks_of(*lasers, *DRIVE, *reversed(scans), scans[0])
    front, rear, hanging, unknown = sorted(looks, key=lambda look: (look.stamp, -look.laser.x))
    assert (front.laser, unknown.laser) == (Pose2D(0.3, 0.0), Pose2D(0.0, 0.0))
    assert rear.laser.x == -0.3
    assert abs(rear.laser.theta) == pytest.approx(math.pi)
    assert (hanging.scan.angle_increment, front.scan.angle_increment) == (-0.1, 0.1)
    (alone,) = looks_of(*lasers, *DRIVE, *scans, scan_topic="scan_rear")
    assert alone == rear
    with pytest.raises(
        InvalidInput,
        match="no scans on '/scan' \\(sensor_msgs/msg/LaserScan\\); its topics are: /scan_front, /scan_rear",
    ):
        looks_of(*lasers, *DRIVE, *scans, scan_topic="/scan")


@pytest.mark.parametrize(
    ("odom", "base", "laser"),
    [
        ("odom_combined", "base_link", "laser"),
        ("robot1/odom", "robot1/base_link", "robot1/laser"),
        ("/odom", "/base_footprint", "/laser"),
        ("world", "chassis", "laser"),
    ],
)
@pytest.mark.parametrize("by_topic", [True, False])
def test_frames_of_other_names_are_found(odom: str, base: str, laser: str, by_topic: bool) -> None:
    times = ((1.0, 0.0), (2.0, 1.0))
    moves = [odometry(at, x, odom, base) if by_topic else tf(at, odom, base, Pose2D(x, 0.0)) for at, x in times]
    named = {} if by_topic or base != "chassis" else {"base": base}
    place = tf(0.0, base, laser, Pose2D(0.2, 0.0), topic="/tf_static")
    (look,) = looks_of(*moves, place, scan(1.5, frame=laser), **named)
    assert (look.odom.x, look.laser.x) == (pytest.approx(0.5), pytest.approx(0.2))


def test_frames_are_named_by_the_user_where_there_are_several() -> None:
    moves = [tf(at, "odom", "base_link", Pose2D(at, 0.0)) for at in (1.0, 2.0)]
    others = [tf(at, "vodom", "odom", Pose2D(5.0, 0.0)) for at in (1.0, 2.0)]
    true = [tf(at, "site", "vodom", Pose2D(0.0, 7.0)) for at in (1.0, 2.0)]
    given = (*moves, *others, *true, scan(1.5))
    (look,) = looks_of(*given, odom="odom", map="site")
    assert look.true is not None
    assert (look.odom.x, look.true.y) == (pytest.approx(1.5), 7.0)
    (wider,) = looks_of(*given, odom="vodom", map="site")
    assert wider.odom.x == pytest.approx(6.5)
    with pytest.raises(InvalidInput, match=r"odometry \(odometry → base_link\).*--odom-frame and --base-frame"):
        looks_of(*given, odom="odometry")


def test_base_frames_that_nothing_connects_are_one_and_the_first_odometry_counts() -> None:
    place = tf(0.0, "base_link", "laser", Pose2D(0.2, 0.0), topic="/tf_static")
    visual = [odometry(at, 70.0, "vodom", "base_footprint", "/vo/odom") for at in (1.0, 2.0)]
    (look,) = looks_of(place, *DRIVE, *visual, scan(1.5))
    assert (look.odom.x, look.laser.x) == (pytest.approx(0.5), pytest.approx(0.2))


def test_scans_without_odometry_have_poses_of_zero_in_the_frame_of_the_laser() -> None:
    recording = recorded(scan(1.0), scan(1.1), scan(1.2))
    assert [(look.odom, look.laser) for look in recording.looks] == [(Pose2D(0.0, 0.0), Pose2D(0.0, 0.0))] * 3
    assert (recording.has_odometry, recording.notes) == (False, (NO_ODOMETRY,))


@pytest.mark.parametrize("topic", ["/tf_static", "/tf"])
@pytest.mark.parametrize("base", ["base_link", "robot1/base_footprint"])
def test_transforms_place_the_laser_where_there_is_no_odometry(topic: str, base: str) -> None:
    """Also those of ROS 1's static_transform_publisher, which repeats them on ``/tf``."""
    places = [tf(at, base, "laser", Pose2D(0.3, 0.1), topic=topic) for at in (1.0, 1.1, 1.2)]
    recording = recorded(*places, scan(1.1))
    (look,) = recording.looks
    assert (look.laser.x, look.laser.y) == (pytest.approx(0.3), pytest.approx(0.1))
    assert not recording.has_odometry


def test_true_poses_count_where_there_is_no_odometry() -> None:
    located = [tf(at, "map", "base_link", Pose2D(at, 2.0)) for at in (1.0, 2.0)]
    recording = recorded(*located, scan(1.5, frame="base_link"))
    (look,) = recording.looks
    assert (recording.has_odometry, look.odom) == (False, Pose2D(0.0, 0.0))
    assert look.true is not None and look.true.x == pytest.approx(1.5)


def test_odometry_in_frames_of_unknown_names_is_not_ignored() -> None:
    moved = [tf(at, "earth", "chassis", Pose2D(at, 0.0)) for at in (1.0, 2.0)]
    with pytest.raises(InvalidInput, match="name those of the robot by --odom-frame and --base-frame"):
        looks_of(*moved, tf(0.0, "chassis", "laser", Pose2D(0.1, 0.0), topic="/tf_static"), scan(1.5))
    (look,) = looks_of(*moved, scan(1.5, frame="chassis"), odom="earth", base="chassis")
    assert look.odom.x == pytest.approx(1.5)


def test_scans_and_odometry_by_two_clocks_are_named() -> None:
    """As of a simulator whose odometry is stamped by the clock of the computer."""
    with pytest.raises(
        InvalidInput, match=r"stamped 34\.0 to 35\.0 s, and odometry and transforms 9001\.0 to 9002\.0 s"
    ):
        looks_of(odometry(9001.0, 0.0), odometry(9002.0, 1.0), scan(34.0), scan(35.0))


def test_several_lasers_without_known_places_are_refused() -> None:
    scans = scan(1.0), scan(1.1, frame="rear", topic="/rear")
    with pytest.raises(InvalidInput, match="transforms between the lasers laser, rear: name one of their topics"):
        looks_of(*scans)
    assert len(looks_of(*scans, scan_topic="/scan")) == 1


def test_the_first_of_several_echoes_is_the_range() -> None:
    (_, kind, message, _) = scan(1.5, count=3)
    assert kind == SCAN
    message.ranges = [Of(echoes=np.array(echoes, np.float32)) for echoes in ([1.0, 3.0], [], [2.0])]
    (look,) = looks_of(*DRIVE, BagMessage("/echoes", ECHOES, message))
    assert look.scan.ranges == [1.0, math.inf, 2.0]


def test_a_missing_bag_reader_is_reported_with_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(InvalidInput, match=r"pip install '\.\[bags\]'"):
        read_recording(BAG)
