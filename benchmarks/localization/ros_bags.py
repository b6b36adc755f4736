"""Bags of ROS: scans, odometry by topic or transforms, and true poses if mapping published ``map`` → ``odom``."""

import math
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.localization.recording import Look, Recording
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import check_scan
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes.frames import MAP, ODOM
from ppaas.transforms.planar import TransformTree, is_level, tf_time

SCAN, ODOMETRY, TRANSFORMS = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"

BASES = ("base_link", "base_footprint")
"""Names of a robot's base frame."""


def read_bag(path: Path) -> Recording:
    """Read a bag of ROS 1 (a file) or ROS 2 (a folder).

    Raises
    ------
    InvalidInput
        The extra ``bags`` is not installed, the bag cannot be read, or no scan has odometry at its time.
    TransformError
        Transforms are not finite, or their frames form a loop.
    """
    return recording_of(list(_messages(path)), path)


def recording_of(messages: Sequence[tuple[str, Any]], path: Path) -> Recording:
    """Return the recording in the messages of a bag.

    Parameters
    ----------
    messages : sequence of (str, message)
        Type and message, as read by ``rosbags``.
    path : Path
        Path of the bag, for error messages.

    Raises
    ------
    InvalidInput, TransformError
        As `read_bag`.
    """
    tree = TransformTree(math.inf)
    for kind, message in messages:
        if kind == TRANSFORMS:
            for moved in message.transforms:
                _set(tree, moved.header, moved.child_frame_id, moved.transform.translation, moved.transform.rotation)
    known = tree.frames()
    for kind, message in messages:
        if kind == ODOMETRY and message.child_frame_id.lstrip("/") not in known:
            pose = message.pose.pose
            _set(tree, message.header, message.child_frame_id, pose.position, pose.orientation)
    return _recording([message for kind, message in messages if kind == SCAN], tree, path)


def _messages(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield type and message, in the order of recording."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError  # noqa: PLC0415 - of the extra bags
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise InvalidInput("reading bags of ROS needs the extra bags: pip install '.[bags]'") from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            wanted = [known for known in reader.connections if known.msgtype in (SCAN, ODOMETRY, TRANSFORMS)]
            for connection, _, raw in reader.messages(connections=wanted) if wanted else ():
                yield connection.msgtype, reader.deserialize(raw, connection.msgtype)
    except (AnyReaderError, OSError, ValueError, LookupError, AssertionError, struct.error) as error:
        raise InvalidInput(f"cannot read the bag {path}: {error}") from error


def _set(tree: TransformTree, header: Any, child: str, place: Any, rotation: Any) -> None:
    """Add a transform to the tree unless it is tilted: cameras may be tilted, planar lasers are not."""
    turned = Quaternion(x=rotation.x, y=rotation.y, z=rotation.z, w=rotation.w)
    if is_level(turned):
        moved = Transform(Vector3(place.x, place.y, 0.0), turned)
        stamped = Header(stamp=Time(header.stamp.sec, header.stamp.nanosec), frame_id=header.frame_id)
        tree.set_message(TransformStamped(stamped, child, moved))


def _recording(scans: list[Any], tree: TransformTree, path: Path) -> Recording:
    base = next((name for name in BASES if name in tree.frames()), BASES[0])
    looks: list[Look] = []
    lasers: list[Pose2D] = []
    for message in scans:
        stamp = tf_time(Time(message.header.stamp.sec, message.header.stamp.nanosec))
        try:
            odom = tree.lookup(ODOM, base, stamp)
            laser = _laser(tree, base, message.header.frame_id.lstrip("/"), stamp)
            true = tree.lookup(MAP, base, stamp) if MAP in tree.frames() else None
        except TransformError:
            continue  # before the first transform, or after the last
        if not looks or stamp > looks[-1].stamp:
            looks.append(Look(stamp, odom, _scan(message), true))
            lasers.append(laser)
    if not looks:
        raise InvalidInput(
            f"{path} has {len(scans)} scans, but no odometry ({ODOM} → {base}) at the time of any of them; "
            f"its frames are {', '.join(tree.frames()) or 'none'}"
        )
    return Recording(tuple(looks), lasers[0])


def _laser(tree: TransformTree, base: str, frame: str, stamp: float) -> Pose2D:
    """Return the pose of the laser in the base frame; the origin if the bag has no transform of it."""
    return tree.lookup(base, frame, stamp) if frame in tree.frames() else Pose2D(0.0, 0.0)


def _scan(message: Any) -> LaserScan:
    scan = LaserScan(
        Header(), angle_min=message.angle_min, angle_max=message.angle_max, angle_increment=message.angle_increment,
        range_min=message.range_min, range_max=message.range_max, ranges=message.ranges.tolist(),
    )  # fmt: skip
    check_scan(scan)
    return scan
