"""Bags of robots without a laser: with a depth camera of any format, or with a lidar that sends point clouds."""

import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ppaas.perception.compressed_depth import compress
from tests.reference.perception import rvl

KINDS = ("16UC1", "32FC1", "png", "rvl", "cloud")
BEGIN = 1_700_000_000
WIDTH, HEIGHT, FOCAL, RISE = 96, 64, 80.0, 0.4
ROOM = (4.0, 3.0)
"""Half the length and half the width of the room around the origin [m]."""

CAMERA, OPTICAL, LIDAR = "/camera/depth", "camera_depth_optical_frame", "lidar"
STEP = 0.05
"""Distance that the robot drives from an image to the next [m]."""


def make_sensor_bag(path: Path, kind: str, *, images: int = 12, ros1: bool = False, transforms: bool = True) -> Path:
    """Write a bag with odometry along x, images or clouds at 10 Hz, and the transform to their sensor.

    Parameters
    ----------
    path : Path
        Path without an ending.
    kind : str
        One of `KINDS`.
    images : int
        Number of images or clouds.
    ros1 : bool
        Whether it is a bag of ROS 1.
    transforms : bool
        Whether it has the transform.
    """
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    if "tf2_msgs/msg/TFMessage" not in store.types:
        text = "geometry_msgs/TransformStamped[] transforms"
        store.register(get_types_from_msg(text, "tf2_msgs/msg/TFMessage"))
    messages = list(_messages(_Maker(store.types, ros1), kind, images, transforms))
    if ros1:
        path = path.with_suffix(".bag")
        with rosbag1.Writer(path) as writer:
            known: dict[str, Any] = {}
            for topic, name, message, at in messages:
                if topic not in known:
                    known[topic] = writer.add_connection(topic, name, typestore=store)
                writer.write(known[topic], at, store.serialize_ros1(message, name))
        return path
    with rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer2:
        known = {}
        for topic, name, message, at in messages:
            if topic not in known:
                known[topic] = writer2.add_connection(topic, name, typestore=store)
            writer2.write(known[topic], at, store.serialize_cdr(message, name))
    return path


def _messages(make: "_Maker", kind: str, images: int, transforms: bool) -> Any:
    if transforms:
        yield "/tf_static", "tf2_msgs/msg/TFMessage", make.static(), BEGIN * 10**9
    for number in range(images):
        x, at = number * STEP, BEGIN * 10**9 + number * 10**8
        yield "/odom", "nav_msgs/msg/Odometry", make.odometry(at, x), at
        if kind == "cloud":
            yield "/points", "sensor_msgs/msg/PointCloud2", make.cloud(at, x), at
            continue
        yield f"{CAMERA}/camera_info", "sensor_msgs/msg/CameraInfo", make.info(at), at
        if kind in ("16UC1", "32FC1"):
            yield f"{CAMERA}/image_raw", "sensor_msgs/msg/Image", make.image(at, x, kind), at
        else:
            yield f"{CAMERA}/image_raw/compressedDepth", "sensor_msgs/msg/CompressedImage", make.packed(at, x, kind), at
        yield "/camera/color/image_raw", "sensor_msgs/msg/Image", make.colours(at), at


def depths(x: float) -> np.ndarray:
    """Return the depths of the room and its floor from a camera that looks along x, (height, width) [m]."""
    right = (np.arange(WIDTH) - (WIDTH - 1) / 2.0) / FOCAL
    down = (np.arange(HEIGHT) - (HEIGHT - 1) / 2.0) / FOCAL
    with np.errstate(divide="ignore"):
        walls = np.minimum(ROOM[0] - x - 0.1, np.where(right == 0.0, np.inf, ROOM[1] / np.abs(right)))
        floor = np.where(down > 0.0, RISE / np.maximum(down, 1e-9), np.inf)
    return np.minimum(walls[np.newaxis, :], floor[:, np.newaxis]).astype(np.float32)


class _Maker:
    """Messages of one version of ROS."""

    def __init__(self, types: Any, ros1: bool) -> None:
        self._types, self._ros1 = types, ros1

    def static(self) -> Any:
        """Return the transform from the robot to the optical frame of the camera, and to the lidar."""
        of = self._of
        optical = of("geometry_msgs/msg/Quaternion", -0.5, 0.5, -0.5, 0.5)
        level = of("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
        placed = [(OPTICAL, of("geometry_msgs/msg/Vector3", 0.1, 0.0, RISE), optical)]
        placed += [(LIDAR, of("geometry_msgs/msg/Vector3", 0.0, 0.0, RISE), level)]
        header = self._header(BEGIN * 10**9, "base_link")
        moved = [
            of("geometry_msgs/msg/TransformStamped", header, child, of("geometry_msgs/msg/Transform", *pose))
            for child, *pose in placed
        ]
        return of("tf2_msgs/msg/TFMessage", moved)

    def odometry(self, at: int, x: float) -> Any:
        """Return odometry along x."""
        of, none = self._of, np.zeros(36)
        vector = of("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
        place, level = (
            of("geometry_msgs/msg/Point", x, 0.0, 0.0),
            of("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0),
        )
        pose = of("geometry_msgs/msg/PoseWithCovariance", of("geometry_msgs/msg/Pose", place, level), none)
        twist = of("geometry_msgs/msg/TwistWithCovariance", of("geometry_msgs/msg/Twist", vector, vector), none)
        return of("nav_msgs/msg/Odometry", self._header(at, "odom"), "base_link", pose, twist)

    def info(self, at: int) -> Any:
        """Return the lens."""
        k = np.array([FOCAL, 0.0, (WIDTH - 1) / 2, 0.0, FOCAL, (HEIGHT - 1) / 2, 0.0, 0.0, 1.0])
        region = self._of("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        matrices = (np.zeros(5), k, np.eye(3).ravel(), np.zeros(12), 0, 0, region)
        return self._of("sensor_msgs/msg/CameraInfo", self._header(at, OPTICAL), HEIGHT, WIDTH, "plumb_bob", *matrices)

    def image(self, at: int, x: float, encoding: str) -> Any:
        """Return a depth image."""
        values = depths(x) if encoding == "32FC1" else (1000.0 * depths(x)).astype(np.uint16)
        return self._image(at, OPTICAL, encoding, values)

    def colours(self, at: int) -> Any:
        """Return an image of colours, which is no depth image."""
        return self._image(at, OPTICAL, "rgb8", np.zeros((2, 2, 3), np.uint8))

    def packed(self, at: int, x: float, kind: str) -> Any:
        """Return a compressed depth image, as PNG or RVL."""
        values = (1000.0 * depths(x)).astype(np.uint16)
        form, data = compress(values)
        if kind == "rvl":
            form = "16UC1; compressedDepth rvl"
            data = struct.pack("<iffII", 0, 0.0, 0.0, WIDTH, HEIGHT) + rvl.encode(values.ravel().tolist())
        octets = np.frombuffer(data, np.uint8)
        return self._of("sensor_msgs/msg/CompressedImage", self._header(at, OPTICAL), form, octets)

    def cloud(self, at: int, x: float) -> Any:
        """Return the points of the walls around a lidar, and of the floor."""
        angles = np.arange(0.0, math.tau, math.radians(1.0))
        c, s = np.cos(angles), np.sin(angles)
        with np.errstate(divide="ignore"):
            ranges = np.minimum((np.copysign(ROOM[0], c) - x) / c, np.abs(ROOM[1] / s))
        rings = [(ranges * c, ranges * s, np.full(len(c), height)) for height in (-0.3, 0.0, 0.3)]
        points = np.concatenate([np.stack(ring, axis=1) for ring in rings]).astype(np.float32)
        fields = [self._of("sensor_msgs/msg/PointField", axis, 4 * n, 7, 1) for n, axis in enumerate("xyz")]
        octets = np.frombuffer(points.tobytes(), np.uint8)
        return self._of(
            "sensor_msgs/msg/PointCloud2", self._header(at, LIDAR), 1, len(points), fields, False, 12, 12 * len(points),
            octets, True,
        )  # fmt: skip

    def _image(self, at: int, frame: str, encoding: str, values: np.ndarray) -> Any:
        octets = np.frombuffer(values.tobytes(), np.uint8)
        height, width = values.shape[:2]
        step = len(octets) // height
        header = self._header(at, frame)
        return self._of("sensor_msgs/msg/Image", header, height, width, encoding, 0, step, octets)

    def _of(self, kind: str, *values: Any) -> Any:
        return self._types[kind](*values)

    def _header(self, nanoseconds: int, frame: str) -> Any:
        stamp = self._types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
        return self._types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **({"seq": 0} if self._ros1 else {}))
