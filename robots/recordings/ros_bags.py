"""Bags of ROS: scans, odometry by topic or transforms, and true poses if mapping published ``map`` → ``odom``."""

import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import check_scan
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.perception.level_scans import LevelScan, level_scan
from ppaas.transforms.planar import tf_time
from robots.recordings.bag_frames import BagFrames
from robots.recordings.recording import Look, RecordedFrames, Recording

SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"

TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
"""Types of transforms: that of tf2, and that of tf, with the same fields, in bags of old robots."""


class BagMessage(NamedTuple):
    """Message of a bag, with its topic and its type."""

    topic: str
    kind: str
    message: Any


def read_bag(path: Path, frames: RecordedFrames) -> Recording:
    """Read a bag of ROS 1 (a file) or ROS 2 (a folder).

    Raises
    ------
    InvalidInput
        The extra ``bags`` is not installed, the bag cannot be read, or no scan has odometry at its time.
    """
    return recording_of(list(_messages(path)), path, frames)


def recording_of(messages: Sequence[BagMessage], path: Path, frames: RecordedFrames) -> Recording:
    """Return the recording in the messages of a bag.

    Transforms on ``tf_static`` hold at all times. Transforms that are not rigid are left out, as in tf2, and so are
    scans that cannot be used.

    Parameters
    ----------
    messages : sequence of BagMessage
        As read by ``rosbags``.
    path : Path
        Path of the bag, for error messages.
    frames : RecordedFrames
        Names in the bag.

    Raises
    ------
    InvalidInput
        As `read_bag`.
    """
    bag = BagFrames(frames)
    for topic, kind, message in messages:
        if kind in TRANSFORMS:
            bag.add_transforms(message.transforms, static=topic.endswith("tf_static"))
    for topic, kind, message in messages:
        if kind == ODOMETRY:
            bag.add_odometry(topic, message)
    bag.join()
    topics = sorted({topic for topic, kind, _ in messages if kind == SCAN})
    wanted = frames.scan_topic
    if wanted is not None and wanted.strip("/") not in [topic.strip("/") for topic in topics]:
        raise InvalidInput(f"{path} has no scans on {wanted!r}, but on {', '.join(topics) or 'no topic'}")
    scans = [
        message
        for topic, kind, message in messages
        if kind == SCAN and (wanted is None or topic.strip("/") == wanted.strip("/"))
    ]
    return Recording(tuple(_looks(scans, bag, path)))


def _messages(path: Path) -> Iterator[BagMessage]:
    """Yield the messages in the order of recording."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError  # noqa: PLC0415 - of the extra bags
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise InvalidInput("reading bags of ROS needs the extra bags: pip install '.[bags]'") from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            wanted = [known for known in reader.connections if known.msgtype in (SCAN, ODOMETRY, *TRANSFORMS)]
            for connection, _, raw in reader.messages(connections=wanted) if wanted else ():
                message = reader.deserialize(raw, connection.msgtype)
                yield BagMessage(connection.topic, connection.msgtype, message)
    except (AnyReaderError, OSError, ValueError, LookupError, AssertionError, struct.error) as error:
        why = str(error) or "a record or its index is damaged, or written by a very old version"
        raise InvalidInput(
            f"cannot read the bag {path}: {why}. Bags of ROS 1 are repaired by: rosbag reindex {path.name}"
        ) from error


def _looks(scans: list[Any], bag: BagFrames, path: Path) -> list[Look]:
    """Return the scans at whose time there is odometry, in the order of their stamps."""
    looks: list[tuple[Look, str]] = []
    refused: list[InvalidInput] = []
    for message in sorted(scans, key=_stamp):
        stamp, frame = _stamp(message), message.header.frame_id.lstrip("/")
        try:
            odom, true = bag.odometry(stamp), bag.true_pose(stamp)
            level = _level(message, bag)
        except TransformError:
            continue  # before the first transform, or after the last
        except InvalidInput as error:
            refused.append(error)
            continue
        if not looks or (stamp, frame) != (looks[-1][0].stamp, looks[-1][1]):
            looks.append((Look(stamp, odom, level.scan, true, level.laser), frame))
    if not looks:
        raise refused[0] if refused else InvalidInput(f"{path} has {len(scans)} scans, but no {bag.missing()}")
    return [look for look, _ in looks]


def _stamp(scan: Any) -> float:
    return tf_time(Time(scan.header.stamp.sec, scan.header.stamp.nanosec))


def _level(message: Any, bag: BagFrames) -> LevelScan:
    """Return a scan as a level laser sends it, with the pose of the laser; the origin without a transform to it."""
    scan = LaserScan(
        Header(frame_id=message.header.frame_id), angle_min=message.angle_min, angle_max=message.angle_max,
        angle_increment=message.angle_increment, range_min=message.range_min, range_max=message.range_max,
        ranges=message.ranges.tolist(), time_increment=float(getattr(message, "time_increment", 0.0)),
    )  # fmt: skip
    check_scan(scan)
    mount = bag.mount(message.header.frame_id.lstrip("/"))
    return LevelScan(scan, Pose2D(0.0, 0.0)) if mount is None else level_scan(scan, mount)
