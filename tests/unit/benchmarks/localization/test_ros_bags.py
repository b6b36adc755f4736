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

from benchmarks.localization.reader import read_recording
from benchmarks.localization.ros_bags import ODOMETRY, SCAN, TRANSFORMS, recording_of
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D

BAG = Path("drive.bag")


def header(seconds: float, frame: str) -> Any:
    whole = math.floor(seconds)
    return Of(stamp=Of(sec=whole, nanosec=round(1e9 * (seconds - whole))), frame_id=frame)


def turned(theta: float) -> Any:
    return Of(x=0.0, y=0.0, z=math.sin(theta / 2), w=math.cos(theta / 2))


def tf(seconds: float, parent: str, child: str, pose: Pose2D, rotation: Any = None) -> tuple[str, Any]:
    moved = Of(translation=Of(x=pose.x, y=pose.y, z=0.3), rotation=rotation or turned(pose.theta))
    return TRANSFORMS, Of(transforms=[Of(header=header(seconds, parent), child_frame_id=child, transform=moved)])


def odometry(seconds: float, x: float) -> tuple[str, Any]:
    pose = Of(position=Of(x=x, y=0.0, z=0.0), orientation=turned(0.0))
    return ODOMETRY, Of(header=header(seconds, "odom"), child_frame_id="base_footprint", pose=Of(pose=pose))


def scan(seconds: float, count: int = 5) -> tuple[str, Any]:
    fields = {"angle_min": 0.0, "angle_max": 0.4, "angle_increment": 0.1, "range_min": 0.1, "range_max": 8.0}
    return SCAN, Of(header=header(seconds, "/laser"), ranges=np.full(count, 2.0, np.float32), **fields)


def test_odometry_is_interpolated_at_the_time_of_a_scan() -> None:
    recording = recording_of([odometry(1.0, 0.0), scan(0.5), scan(1.5), odometry(2.0, 1.0), scan(3.0)], BAG)
    (look,) = recording.looks
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
    recording = recording_of([*joints, odometry(1.0, 9.0), odometry(2.0, 9.0), scan(1.5)], BAG)
    (look,) = recording.looks
    assert look.odom == Pose2D(1.0, 0.0)
    assert look.true is not None
    assert look.true.distance_to(Pose2D(5.0, 1.0)) < 1e-9
    assert recording.laser == Pose2D(0.2, 0.1)


def test_a_bag_without_odometry_for_any_scan_is_refused() -> None:
    with pytest.raises(
        InvalidInput, match=r"1 scans, but no odometry .* at the time of any of them.*base_footprint, odom"
    ):
        recording_of([odometry(1.0, 0.0), scan(30.0)], BAG)


def test_a_scan_of_wrong_size_is_refused() -> None:
    with pytest.raises(InvalidInput, match="ranges, not 9"):
        recording_of([odometry(1.0, 0.0), odometry(2.0, 0.0), scan(1.5, count=9)], BAG)


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
    with pytest.raises(InvalidInput, match=r"cannot read the bag .*drive.bag: ."):
        read_recording(bag)
