"""Bags of ROS: scans, odometry by topic or transforms, and true poses if mapping published ``map`` → ``odom``."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Fields
from typing import Any

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import check_scan
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.perception.level_scans import LevelScan, level_scan
from ppaas.transforms.planar import tf_time
from robots.recordings.bag import ROS_ENCODINGS, Bag
from robots.recordings.bag import messages as in_words
from robots.recordings.bag_frames import BagFrames
from robots.recordings.bag_objects import BagObjects, full_type
from robots.recordings.bag_times import BagMessage, of_one_clock, with_recorded_times, with_stamps
from robots.recordings.recording import NO_ODOMETRY, Look, RecordedFrames, Recording
from robots.recordings.sensor_scans import CAMERA_INFO, CLOUD, COMPRESSED, IMAGE, SensorScans

SCAN, ECHOES, ODOMETRY = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/MultiEchoLaserScan", "nav_msgs/msg/Odometry"

TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
"""Types of transforms: tf2's, and in bags of old robots tf's, with the same fields."""

SCANS = (SCAN, ECHOES)
USED = (*SCANS, ODOMETRY, *TRANSFORMS)
"""Types of the messages that are used."""

FEW = 0.02
"""Share of scans before the first or after the last odometry up to which they are not worth a note."""


def read_bag(path: Path, frames: RecordedFrames) -> Recording:
    """Read a bag of ROS 1 or ROS 2, a file or a folder.

    Raises
    ------
    InvalidInput
        The extra ``bags`` is not installed, the bag cannot be read or has no scans, or it has odometry, but at the time
        of no scan.
    """
    objects, bag, sensors = BagObjects(), Bag(path), SensorScans()
    messages, told = _with_scans(list(_messages(bag, objects, sensors, frames.scan_topic)), sensors, frames.scan_topic)
    recording = recording_of(messages, path, frames, bag.contents)
    damaged = [f"{in_words(count)} on {topic} left out: damaged" for topic, count in objects.damaged.items()]
    return replace(recording, notes=(*bag.notes(), *damaged, *told, *recording.notes))


def recording_of(
    messages: Sequence[BagMessage], path: Path, frames: RecordedFrames, contents: Callable[[], str]
) -> Recording:
    """Return the recording in the messages of a bag.

    Transforms on ``tf_static`` hold at all times. Transforms that are not rigid are left out, as in tf2, and so are
    scans that cannot be used. Without odometry, the poses of the robot are zero, and the laser's frame is the robot's
    unless transforms connect the two.

    Parameters
    ----------
    messages : sequence of BagMessage
        As read by ``rosbags``.
    path : Path
        Path of the bag, for error messages.
    frames : RecordedFrames
        Names in the bag.
    contents : callable
        Returns the topics of the bag, for error messages.

    Raises
    ------
    InvalidInput
        As `read_bag`.
    """
    notes = with_stamps(messages, _headers)
    notes += with_recorded_times(messages, _headers, _is_scan)
    messages, more = of_one_clock(messages, _headers, _is_scan)
    bag = BagFrames(frames)
    for topic, kind, message, _ in messages:
        if kind in TRANSFORMS and not is_static(topic):
            bag.hear_parents(message.transforms)
    for topic, kind, message, _ in messages:
        if kind in TRANSFORMS:
            bag.add_transforms(message.transforms, static=is_static(topic))
    for topic, kind, message, _ in messages:
        if kind == ODOMETRY:
            bag.add_odometry(topic, message)
    bag.join()
    notes += more + bag.notes()
    scans = [(message.topic, message.message) for message in messages if message.kind in SCANS]
    wanted = frames.scan_topic
    chosen = [message for topic, message in scans if wanted is None or _is_of(topic, wanted)]
    if not chosen:
        where = "" if wanted is None else f" on {wanted!r}"
        raise InvalidInput(f"{path} has no scans{where} ({SCAN}); its topics are: {contents()}")
    lasers = {scan.header.frame_id.lstrip("/") for scan in chosen}
    has_odometry = bag.has_odometry(lasers)
    if has_odometry:
        _check_one_robot(lasers, bag, path)
        notes += _unplaced(lasers, bag)
    else:
        _check_frames(lasers, bag, path)
        notes.append(NO_ODOMETRY)
    looks, left_out = _looks(chosen, bag, path, bag.odometry if has_odometry else lambda _: Pose2D(0.0, 0.0))
    return Recording(tuple(looks), (*notes, *left_out), has_odometry)


def _is_scan(message: BagMessage) -> bool:
    return message.kind in SCANS


def is_static(topic: str) -> bool:
    """Return whether the transforms of a topic hold at all times."""
    return topic.endswith("tf_static")


def _headers(message: BagMessage) -> list[tuple[str, Any]]:
    """Return the frames and headers in a message that are of its time."""
    if message.kind in TRANSFORMS:
        moved = [] if is_static(message.topic) else message.message.transforms
        return [(each.child_frame_id, each.header) for each in moved]
    return [(message.message.header.frame_id, message.message.header)]


def _check_one_robot(frames: set[str], bag: BagFrames, path: Path) -> None:
    """Raise ``InvalidInput`` if there are scans of a laser that moves in another frame than the robot."""
    others = sorted(frame for frame in frames if bag.mount(frame) is None and bag.moves(frame))
    if others and bag.is_base_known:
        raise InvalidInput(
            f"{path} has scans of several robots: no transform leads from {bag.base} to {', '.join(others)}, which "
            "moves by itself; name the topic of one robot by --scan-topic, and its frame by --base-frame"
        )


def _unplaced(frames: set[str], bag: BagFrames) -> list[str]:
    """Return notes on lasers whose place on the robot is not known."""
    return [
        f"no transform leads from {bag.base} to the laser {frame or 'without a frame'}: it is taken to be there, and "
        "to look ahead"
        for frame in sorted(frames)
        if bag.mount(frame) is None
    ]


def _check_frames(frames: set[str], bag: BagFrames, path: Path) -> None:
    """Raise ``InvalidInput`` if scans of several lasers have no known place on the robot."""
    if len(frames) > 1 and any(bag.mount(frame) is None for frame in frames):
        raise InvalidInput(
            f"{path} has neither odometry nor transforms between the lasers {', '.join(sorted(frames))}: name one of "
            "their topics by --scan-topic"
        )


def _messages(bag: Bag, objects: BagObjects, sensors: SensorScans, wanted: str | None) -> Iterator[BagMessage]:
    """Yield the messages that are used, in the order of recording.

    Depth images and clouds become scans until the first scan of a laser comes, or if they are on the topic whose scans
    are wanted. Their type stays.
    """
    has_laser = False
    for message in bag.messages():
        topic, kind = message.channel.topic, full_type(message.channel.type)
        if message.channel.encoding not in ROS_ENCODINGS:
            continue
        if kind in USED and (found := objects.read(message)) is not None:
            has_laser = has_laser or kind in SCANS
            yield BagMessage(topic, kind, found, message.log_time)
        elif _is_of(topic, wanted) if wanted is not None and kind != CAMERA_INFO else not has_laser:
            read = objects.read(message) if sensors.may_use(topic, kind) else None
            if read is not None and (scan := sensors.scan(topic, kind, read)) is not None:
                yield BagMessage(topic, kind, scan, message.log_time)


def _is_of(topic: str, wanted: str) -> bool:
    return topic.strip("/") == wanted.strip("/")


def _with_scans(
    messages: list[BagMessage], sensors: SensorScans, wanted: str | None
) -> tuple[list[BagMessage], list[str]]:
    """Return the messages with the scans of one kind of sensor, the best that is there, and a note if it is no laser.

    Lasers are better than depth images, and those better than clouds.
    """
    kinds = {message.kind for message in messages if wanted is None or _is_of(message.topic, wanted)}
    best = next((kind for kind in (*SCANS, IMAGE, COMPRESSED, CLOUD) if kind in kinds), SCAN)
    used = SCANS if best in SCANS else (IMAGE, COMPRESSED) if best != CLOUD else (CLOUD,)
    kept = [message for message in messages if message.kind in (*used, ODOMETRY, *TRANSFORMS)]
    if best in SCANS:
        return kept, []
    scans = [message._replace(kind=SCAN) if message.kind in used else message for message in kept]
    frames = [
        Fields(header=Fields(stamp=Fields(sec=0, nanosec=0), frame_id=parent), child_frame_id=child, transform=pose)
        for parent, child, pose in sensors.frames()
    ]
    static = [BagMessage("/tf_static", TRANSFORMS[0], Fields(transforms=frames))] if best != CLOUD else []
    count = sum(message.kind in used for message in kept)
    what = "point clouds" if best == CLOUD else "depth images"
    broken = [f"{in_words(sensors.broken)} left out: a depth image or cloud is broken"] if sensors.broken else []
    return [*static, *scans], [f"there is no laser: {count} {what} are taken as scans", *broken]


def _looks(
    scans: list[Any], bag: BagFrames, path: Path, odometry: Callable[[float], Pose2D]
) -> tuple[list[Look], list[str]]:
    """Return the scans at whose time there is odometry, in the order of their stamps, and notes on the others."""
    looks: list[tuple[Look, str]] = []
    refused: list[InvalidInput] = []
    repeated = early = 0
    for message in sorted(scans, key=_stamp):
        stamp, frame = _stamp(message), message.header.frame_id.lstrip("/")
        try:
            odom, true = odometry(stamp), bag.true_pose(stamp)
            level = _level(message, bag)
        except TransformError:
            early += 1  # before the first transform, or after the last
            continue
        except InvalidInput as error:
            refused.append(error)
            continue
        if looks and (stamp, frame) == (looks[-1][0].stamp, looks[-1][1]):
            repeated += 1
            continue
        looks.append((Look(stamp, odom, level.scan, true, level.laser), frame))
    if not looks:
        stamps = [_stamp(scan) for scan in scans]
        missing = bag.missing(min(stamps), max(stamps))
        raise refused[0] if refused else InvalidInput(f"{path} has {len(scans)} scans, but no {missing}")
    reasons = [
        (early if early > FEW * len(scans) else 0, "there is no odometry at their time"),
        (repeated, "they have frame and stamp of another one"),
        (len(refused), str(refused[0]) if refused else ""),
    ]
    notes = [f"{count} of {len(scans)} scans left out: {reason}" for count, reason in reasons if count]
    return [look for look, _ in looks], notes


def _stamp(scan: Any) -> float:
    return tf_time(Time(scan.header.stamp.sec, scan.header.stamp.nanosec))


def _level(message: Any, bag: BagFrames) -> LevelScan:
    """Return a scan as a level laser sends it, with the pose of the laser; the origin without a transform to it."""
    scan = LaserScan(
        Header(frame_id=message.header.frame_id), angle_min=message.angle_min, angle_max=message.angle_max,
        angle_increment=message.angle_increment, range_min=message.range_min, range_max=message.range_max,
        ranges=_ranges(message), time_increment=float(getattr(message, "time_increment", 0.0)),
    )  # fmt: skip
    check_scan(scan)
    mount = bag.mount(message.header.frame_id.lstrip("/"))
    return LevelScan(scan, Pose2D(0.0, 0.0)) if mount is None else level_scan(scan, mount)


def _ranges(message: Any) -> list[float | None]:
    """Return the ranges of a scan, of several echoes the first."""
    return [_first(beam.echoes) if hasattr(beam, "echoes") else float(beam) for beam in message.ranges]


def _first(echoes: Any) -> float:
    return float(echoes[0]) if len(echoes) else math.inf
