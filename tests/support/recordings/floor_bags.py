"""Bags of a drive over two floors, with a lift between them."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags import rosbag2
from rosbags.typesys import Stores, get_typestore

from ppaas.buildings.riding.air import GAS

SCAN, ODOMETRY, PRESSURE = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "sensor_msgs/msg/FluidPressure"

ROOMS = {0: (8.0, 6.0), 1: (5.0, 4.0)}
"""Width and depth of the room of each floor, around the lift in its middle [m]."""

STOREY, BEAMS, PERIOD = 3.5, 120, 0.25


def ranges_in(room: tuple[float, float], x: float) -> NDArray[np.float32]:
    """Return the ranges of a laser at (x, 0) in a room [m]."""
    angles = -math.pi + np.arange(BEAMS) * 2 * math.pi / BEAMS
    c, s = np.cos(angles), np.sin(angles)
    half, deep = 0.5 * room[0], 0.5 * room[1]
    with np.errstate(divide="ignore"):
        return np.minimum((np.copysign(half, c) - x) / c, np.copysign(deep, s) / s).astype(np.float32)


def states() -> list[tuple[float, int, float, float]]:
    """Return time [s], floor, x [m] and height [m] of a drive: up, and down again."""
    found: list[tuple[float, int, float, float]] = []
    for floor, height in ((0, 0.0), (1, STOREY), (0, 0.0)):
        if found:
            last = found[-1][3]
            found += [(0.0, -1, 0.0, last + (height - last) * step / 12) for step in range(1, 12)]
        found += [(0.0, floor, 0.8 * math.sin(math.pi * step / 80), height) for step in range(81)]
    return [(number * PERIOD, floor, x, height) for number, (_, floor, x, height) in enumerate(found)]


def make_floor_bag(path: Path, *, barometer: bool = True, rises: bool = True) -> Path:
    """Write a bag of ROS 2; heights are from a barometer, or from the odometry."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    writer = rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP)
    random = np.random.default_rng(1)
    with writer:
        known: dict[str, Any] = {}
        for seconds, floor, x, height in states():
            at = int((1_700_000_000 + seconds) * 1e9)
            header = _header(types, at, "odom")
            z = height if rises and not barometer else 0.0
            messages = [("/odom", ODOMETRY, _odometry(types, header, x, z))]
            if barometer:
                drifted = height + 0.01 * seconds + random.normal(0.0, 0.1)
                pressure = types[PRESSURE](_header(types, at, "base_link"), 100_000.0 * math.exp(-drifted / GAS), 0.0)
                messages.append(("/barometer", PRESSURE, pressure))
            ranges = ranges_in(ROOMS[floor], x) if floor >= 0 else np.full(BEAMS, 0.9, np.float32)
            messages.append(("/scan", SCAN, _scan(types, at, ranges)))
            for topic, kind, message in messages:
                if topic not in known:
                    known[topic] = writer.add_connection(topic, kind, typestore=store)
                writer.write(known[topic], at, store.serialize_cdr(message, kind))
    return path


def _header(types: Any, at: int, frame: str) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](sec=at // 10**9, nanosec=at % 10**9)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _odometry(types: Any, header: Any, x: float, z: float) -> Any:
    vector, point = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Point"]
    pose = types["geometry_msgs/msg/Pose"](
        position=point(x=x, y=0.0, z=z), orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    )
    twist = types["geometry_msgs/msg/Twist"](linear=vector(x=0.0, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0))
    none = np.zeros(36)
    return types[ODOMETRY](
        header=header, child_frame_id="base_link",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=none),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=none),
    )  # fmt: skip


def _scan(types: Any, at: int, ranges: NDArray[np.float32]) -> Any:
    step = 2 * math.pi / BEAMS
    return types[SCAN](
        header=_header(types, at, "base_link"), angle_min=-math.pi, angle_max=math.pi - step, angle_increment=step,
        time_increment=0.0, scan_time=0.1, range_min=0.1, range_max=20.0, ranges=ranges,
        intensities=np.zeros(0, np.float32),
    )  # fmt: skip
