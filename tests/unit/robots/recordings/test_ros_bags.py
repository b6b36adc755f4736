"""Bags of ROS."""

import math
import sys
from pathlib import Path
from types import SimpleNamespace as Of
from typing import Any

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from robots.recordings.reader import read_recording
from robots.recordings.recording import Look, RecordedFrames
from robots.recordings.ros_bags import ODOMETRY, SCAN, TRANSFORMS, BagMessage, recording_of

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
    return recording_of(messages, BAG, RecordedFrames(**names)).looks


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
    with pytest.raises(InvalidInput, match="no scans on '/scan', but on /scan_front, /scan_hanging, /scan_rear"):
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


def test_a_missing_bag_reader_is_reported_with_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(InvalidInput, match=r"pip install '\.\[bags\]'"):
        read_recording(BAG)


def keep(writer: Any, store: Any, serialize: Any) -> None:
    """Write a scan between two messages of odometry, as a robot records them."""
    types = store.types

    def stamped(seconds: float, frame: str) -> Any:
        given = header(seconds, frame)
        stamp = types["builtin_interfaces/msg/Time"](given.stamp.sec, given.stamp.nanosec)
        numbered = {"seq": 0} if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else {}
        return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **numbered)

    def odom(seconds: float, x: float) -> Any:
        vector, none = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0), np.zeros(36)
        at = types["geometry_msgs/msg/Point"](x, 0.0, 0.0), types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
        pose = types["geometry_msgs/msg/PoseWithCovariance"](types["geometry_msgs/msg/Pose"](*at), none)
        twist = types["geometry_msgs/msg/TwistWithCovariance"](types["geometry_msgs/msg/Twist"](vector, vector), none)
        return types[ODOMETRY](stamped(seconds, "odom"), "base_footprint", pose, twist)

    seen = np.full(5, 2.0, np.float32)
    look = types[SCAN](stamped(1.5, "laser"), 0.0, 0.4, 0.1, 0.0, 0.2, 0.1, 8.0, seen, np.zeros(0, np.float32))
    connections = {kind: writer.add_connection(kind[0], kind, typestore=store) for kind in (ODOMETRY, SCAN)}
    for kind, message in ((ODOMETRY, odom(1.0, 0.0)), (SCAN, look), (ODOMETRY, odom(2.0, 1.0))):
        writer.write(connections[kind], 1, serialize(message, kind))


@pytest.mark.parametrize("name", ["drive.bag", "mcap", "sqlite3"])
def test_bags_of_both_ros_versions_are_read(tmp_path: Path, name: str) -> None:
    bag = tmp_path / name
    if bag.suffix:
        store = get_typestore(Stores.ROS1_NOETIC)
        with rosbag1.Writer(bag) as old:
            keep(old, store, store.serialize_ros1)
    else:
        store = get_typestore(Stores.LATEST)
        with rosbag2.Writer(bag, version=9, storage_plugin=rosbag2.StoragePlugin[name.upper()]) as new:
            keep(new, store, store.serialize_cdr)
    (look,) = read_recording(bag).looks
    assert (look.stamp, look.scan.ranges) == (1.5, [2.0] * 5)
    assert look.odom.distance_to(Pose2D(0.5, 0.0)) < 1e-9


@pytest.mark.parametrize("content", [b"", b"rubbish", b"#ROSBAG V2.0\n", b"#ROSBAG V2.0\n" + bytes(4096)])
def test_an_unreadable_bag_is_refused(tmp_path: Path, content: bytes) -> None:
    bag = tmp_path / "drive.bag"
    bag.write_bytes(content)
    with pytest.raises(InvalidInput, match=r"cannot read the bag .*drive.bag: \w.* rosbag reindex drive.bag"):
        read_recording(bag)
