"""Compact frames: scans, odometry and velocities of small robots as little-endian numbers.

A microcontroller writes and reads them at fixed places, without JSON and without memory of their size. All begin with
the same eight bytes:

======  ======  ====================================================================================================
byte    type    content
======  ======  ====================================================================================================
0       uint8   kind: 1 scan, 2 odometry, 3 velocity
1       uint8   length of the name of the frame at the end of a scan [bytes], 0 otherwise
2–3     uint16  count: number of ranges of a scan, number of values otherwise
4–7     uint32  stamp [ms] on the clock of the robot, which may start anywhere and wrap around; 0 means now
======  ======  ====================================================================================================

They are followed, from byte 8 on, by

======== ==========================================================================================================
scan     ``angle_min``, ``angle_increment`` [rad] as float32, ``range_min``, ``range_max`` [mm] as uint16, and the
         ranges [mm] as uint16: 0 for no reading, 65535 for nothing within reach; then the name of the laser's frame
odometry x, y [m], yaw [rad], then vx, vy [m/s] and wz [rad/s] in the frame of the robot, as float32
velocity vx, vy [m/s], wz [rad/s] as float32
======== ==========================================================================================================

The first byte distinguishes them from JSON and from a map in CBOR, so a client may send them on any connection.
"""

import math
import struct
from collections.abc import Sequence
from typing import Final

import numpy as np

from ppaas.errors import MalformedMessage
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.wire.binary.binary_frame import BinaryFrame

SCAN, ODOM, CMD_VEL = 1, 2, 3
"""Kinds of compact frames."""

NO_READING, OUT_OF_REACH = 0, 0xFFFF
"""Ranges without a distance."""

_HEAD: Final = struct.Struct("<BBHI")
_SCAN: Final = struct.Struct("<ffHH")
_ODOM: Final = struct.Struct("<6f")
_CMD_VEL: Final = struct.Struct("<3f")


def is_compact(frame: bytes) -> bool:
    """Return whether a binary frame begins as a compact frame; neither JSON nor a map in CBOR does."""
    return frame[:1] in (b"\x01", b"\x02", b"\x03")


def compact_to_json(frame: bytes) -> bytes:
    """Return the operation for which a compact frame of a client stands, as JSON.

    Raises
    ------
    MalformedMessage
        The frame has another size than its head says, its numbers are not finite, or its kind is not for the cloud.
    """
    if len(frame) < _HEAD.size:
        raise MalformedMessage(f"a compact frame has at least {_HEAD.size} bytes, not {len(frame)}")
    kind, name_size, count, stamp = _HEAD.unpack_from(frame)
    if kind == SCAN:
        return _publication("scan", encode(_scan(frame, name_size, count, stamp)))
    if name_size:
        raise MalformedMessage("byte 1 of a compact frame is 0, except in a scan")
    if kind == ODOM:
        return _publication("odom", encode(_odometry(frame, count, stamp)))
    return _publication("cmd_vel", encode(_twist(_numbers(_CMD_VEL, frame, count, "velocity"))))


def compact_cmd_vel(twist: bytes) -> BinaryFrame:
    """Return a velocity as a compact frame, without a stamp.

    Parameters
    ----------
    twist : bytes
        ``geometry_msgs/Twist`` or ``geometry_msgs/TwistStamped`` as JSON.

    Raises
    ------
    MalformedMessage
        It is neither.
    """
    velocity = decode(Twist, twist)
    values = velocity.linear.x, velocity.linear.y, velocity.angular.z
    return BinaryFrame(_HEAD.pack(CMD_VEL, 0, len(values), 0) + _CMD_VEL.pack(*values))


def _publication(topic: str, message: bytes) -> bytes:
    return b'{"op":"publish","topic":"%b","msg":%b}' % (topic.encode(), message)


def _check_size(frame: bytes, size: int, what: str) -> None:
    if len(frame) != size:
        raise MalformedMessage(f"this compact {what} has {size} bytes by its head, not {len(frame)}")


def _numbers(layout: struct.Struct, frame: bytes, count: int, what: str) -> tuple[float, ...]:
    _check_size(frame, _HEAD.size + layout.size, what)
    numbers: tuple[float, ...] = layout.unpack_from(frame, _HEAD.size)
    if count != len(numbers):
        raise MalformedMessage(f"a compact {what} has {len(numbers)} values, not {count}")
    if not all(map(math.isfinite, numbers)):
        raise MalformedMessage(f"the values of a compact {what} must be finite numbers")
    return numbers


def _time(stamp: int) -> Time:
    return Time(stamp // 1000, stamp % 1000 * 1_000_000)


def _scan(frame: bytes, name_size: int, count: int, stamp: int) -> LaserScan:
    begin = _HEAD.size + _SCAN.size
    end = begin + 2 * count
    _check_size(frame, end + name_size, "scan")
    angle_min, step, nearest, farthest = _SCAN.unpack_from(frame, _HEAD.size)
    if not (count and math.isfinite(angle_min) and math.isfinite(step)):
        raise MalformedMessage("a compact scan needs ranges, and finite angles")
    try:
        name = frame[end:].decode()
    except UnicodeDecodeError as error:
        raise MalformedMessage("the name of the frame of a compact scan is not UTF-8") from error
    return LaserScan(
        header=Header(stamp=_time(stamp), frame_id=name), angle_min=angle_min,
        angle_max=angle_min + step * (count - 1), angle_increment=step, range_min=nearest / 1000.0,
        range_max=farthest / 1000.0, ranges=_ranges(frame[begin:end]),
    )  # fmt: skip


def _ranges(data: bytes) -> list[float | None]:
    """Return ranges [m]: 0 for no reading, None for nothing within reach, as null is infinity in scans in JSON."""
    millimetres = np.frombuffer(data, dtype="<u2")
    ranges: list[float | None] = (millimetres / 1000.0).tolist()
    for beam in np.flatnonzero(millimetres == OUT_OF_REACH).tolist():
        ranges[beam] = None
    return ranges


def _odometry(frame: bytes, count: int, stamp: int) -> Odometry:
    x, y, yaw, *velocity = _numbers(_ODOM, frame, count, "odometry")
    pose = PoseWithCovariance(Pose.of(Pose2D(x, y, yaw)))
    return Odometry(Header(stamp=_time(stamp)), "", pose, TwistWithCovariance(_twist(velocity)))


def _twist(velocity: Sequence[float]) -> Twist:
    vx, vy, wz = velocity
    return Twist(Vector3(vx, vy, 0.0), Vector3(0.0, 0.0, wz))
