"""Bags of ROS of all formats, as tools leave them, with a drive of a robot in a room."""

import math
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"

KINDS = ("bag", "bag-bz2", "bag-lz4", "mcap", "db3", "mcap-ros1", "mcap-no-profile")
"""Formats: bags of ROS 1 with each compression, of ROS 2 in both stores, and MCAP of other programs."""

BEGIN = 1_700_000_000
BEAMS = 90

_STORE, _STORE_1 = get_typestore(Stores.ROS2_JAZZY), get_typestore(Stores.ROS1_NOETIC)


def make_bag(
    path: Path, kind: str, scans: int = 30, *, files: int = 1, odometry: bool = True, compress: str = ""
) -> Path:
    """Write a bag with scans and odometry at 10 Hz, and return its path.

    Parameters
    ----------
    path : Path
        Path without an ending; bags of ROS 2 are folders.
    kind : str
        One of `KINDS`.
    scans : int
        Number of scans.
    files : int
        Number of files of a bag of ROS 2.
    odometry : bool
        Whether there is odometry.
    compress : {"", "file", "message"}
        What is compressed in a bag of ROS 2.
    """
    if kind.startswith("bag"):
        return _ros1(path.with_suffix(".bag"), kind.partition("-")[2], scans, odometry)
    if kind in ("mcap", "db3"):
        return _ros2(path, kind, scans, files, odometry, compress)
    path = path.with_suffix(".mcap")
    path.write_bytes(_mcap(kind == "mcap-ros1", scans, odometry))
    return path


def foreign_channels(*messages: tuple[str, str, bytes]) -> bytes:
    """Return an MCAP file of messages given as topic, encoding and content."""
    stream = BytesIO()
    writer: Any = Writer(stream)
    writer.start(profile="", library="tests")
    for topic, encoding, content in messages:
        schema = writer.register_schema("tests.Any", "jsonschema" if encoding == "json" else encoding, b"{}")
        writer.add_message(writer.register_channel(topic, encoding, schema), BEGIN * 10**9, content, BEGIN * 10**9)
    writer.finish()
    return stream.getvalue()


def drive(store: Any, scans: int, *, odometry: bool = True) -> Iterator[tuple[str, str, Any, int]]:
    """Yield topic, type, message and time [ns] of a drive of 1 m along x."""
    for number in range(scans):
        x, nanoseconds = -0.5 + number / scans, BEGIN * 10**9 + number * 10**8
        if odometry:
            yield "/odom", ODOMETRY, _odometry(store.types, nanoseconds, x), nanoseconds
        yield "/scan", SCAN, _scan(store.types, nanoseconds, x), nanoseconds


def room(x: float) -> np.ndarray:
    """Return the ranges of a laser at (x, 0.3) in a room of 8 × 6 m [m]."""
    angles = -math.pi + np.arange(BEAMS) * 2 * math.pi / BEAMS
    c, s = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        return np.minimum((np.copysign(4.0, c) - x) / c, (np.copysign(3.0, s) - 0.3) / s).astype(np.float32)


def _ros1(path: Path, compression: str, scans: int, odometry: bool) -> Path:
    writer = rosbag1.Writer(path)
    writer.chunk_threshold = 16384
    if compression:
        writer.set_compression(rosbag1.Writer.CompressionFormat[compression.upper()])
    with writer:
        known: dict[str, Any] = {}
        for topic, kind, message, at in drive(_STORE_1, scans, odometry=odometry):
            if topic not in known:
                known[topic] = writer.add_connection(topic, kind, typestore=_STORE_1)
            writer.write(known[topic], at, _STORE_1.serialize_ros1(message, kind))
    return path


def _ros2(path: Path, kind: str, scans: int, files: int, odometry: bool, compress: str) -> Path:
    plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
    messages = list(drive(_STORE, scans, odometry=odometry))
    share = -(-len(messages) // files)
    parts = [messages[begin : begin + share] for begin in range(0, len(messages), share)]
    names = []
    for number, part in enumerate(parts):
        writer = rosbag2.Writer(path if files == 1 else path / f"part_{number}", version=9, storage_plugin=plugin)
        if compress:
            mode = rosbag2.CompressionMode[compress.upper()]
            writer.set_compression(mode, rosbag2.CompressionFormat.ZSTD)
        with writer:
            known: dict[str, Any] = {}
            for topic, name, message, at in part:
                if topic not in known:
                    known[topic] = writer.add_connection(topic, name, typestore=_STORE)
                writer.write(known[topic], at, _STORE.serialize_cdr(message, name))
        names.append(f"{path.name}_{number}.{kind}")
        if files > 1:
            (path / f"part_{number}" / f"part_{number}.{kind}").rename(path / names[-1])
    if files > 1:
        listed = "".join(f"    - {name}\n" for name in names)
        text = f"rosbag2_bagfile_information:\n  version: 9\n  relative_file_paths:\n{listed}"
        (path / "metadata.yaml").write_text(text)
    return path


def _mcap(ros1: bool, scans: int, odometry: bool) -> bytes:
    store, stream = _STORE_1 if ros1 else _STORE, BytesIO()
    writer: Any = Writer(stream, chunk_size=4096, compression=CompressionType.ZSTD)
    writer.start("ros1" if ros1 else "", "tests")
    known: dict[str, int] = {}
    for topic, kind, message, at in drive(store, scans, odometry=odometry):
        if topic not in known:
            text, _ = store.generate_msgdef(kind, ros_version=1 if ros1 else 2)
            schema = writer.register_schema(
                kind.replace("/msg/", "/") if ros1 else kind, "ros1msg" if ros1 else "ros2msg", text.encode()
            )
            known[topic] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schema)
        data = store.serialize_ros1(message, kind) if ros1 else store.serialize_cdr(message, kind)
        writer.add_message(known[topic], at, bytes(data), at)
    writer.finish()
    return stream.getvalue()


def _header(types: Any, nanoseconds: int, frame: str) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
    numbered = {"seq": 0} if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **numbered)


def _odometry(types: Any, nanoseconds: int, x: float) -> Any:
    vector, none = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0), np.zeros(36)
    at = types["geometry_msgs/msg/Point"](x, 0.3, 0.0), types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    pose = types["geometry_msgs/msg/PoseWithCovariance"](types["geometry_msgs/msg/Pose"](*at), none)
    twist = types["geometry_msgs/msg/TwistWithCovariance"](types["geometry_msgs/msg/Twist"](vector, vector), none)
    return types[ODOMETRY](_header(types, nanoseconds, "odom"), "base_link", pose, twist)


def _scan(types: Any, nanoseconds: int, x: float) -> Any:
    step = 2 * math.pi / BEAMS
    return types[SCAN](
        _header(types, nanoseconds, "base_link"), -math.pi, math.pi - step, step, 0.0, 0.1, 0.05, 20.0, room(x),
        np.zeros(0, np.float32),
    )  # fmt: skip
