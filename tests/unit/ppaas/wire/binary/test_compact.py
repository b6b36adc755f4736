"""Compact frames of small robots."""

import json
import math
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.messages import decode
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.wire.binary.compact import compact_cmd_vel, compact_to_json, is_compact
from ppaas.wire.operations import Publish
from ppaas.wire.rosbridge import decode_operation

FLOATS = st.floats(width=32, allow_nan=False, allow_infinity=False)
STAMPS = st.integers(0, 2**32 - 1)
ODOM = struct.pack("<BBHI6f", 2, 0, 6, 0, *[0.0] * 6)


def scan_frame(
    ranges: list[int], first: float = -1.0, step: float = 0.5, near: int = 100, far: int = 9000,
    stamp: int = 0, name: bytes = b"",
) -> bytes:  # fmt: skip
    """Return a scan byte by byte as docs/protocol.md describes it."""
    head = struct.pack("<BBHI", 1, len(name), len(ranges), stamp) + struct.pack("<ffHH", first, step, near, far)
    return head + struct.pack(f"<{len(ranges)}H", *ranges) + name


def published(frame: bytes) -> tuple[str, bytes]:
    assert is_compact(frame)
    operation = decode_operation(compact_to_json(frame))
    assert isinstance(operation, Publish)
    return operation.topic, bytes(operation.msg)


def scan_of(frame: bytes) -> LaserScan:
    topic, message = published(frame)
    assert topic == "scan"
    return decode(LaserScan, message)


@given(st.lists(st.integers(0, 65535), min_size=1, max_size=20), FLOATS, st.integers(0, 65535), STAMPS)
def test_a_scan_has_the_numbers_of_its_frame(ranges: list[int], first: float, far: int, stamp: int) -> None:
    scan = scan_of(scan_frame(ranges, first=first, far=far, stamp=stamp))
    assert scan.ranges == [None if each == 65535 else each / 1000 for each in ranges]
    assert (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max) == (first, 0.5, 0.1, far / 1000)
    assert scan.angle_max == first + 0.5 * (len(ranges) - 1)
    assert (scan.header.stamp.secs, scan.header.stamp.nsecs) == (stamp // 1000, stamp % 1000 * 1_000_000)


def test_a_scan_names_the_frame_of_its_laser_at_its_end() -> None:
    assert scan_of(scan_frame([1, 2], name=b"base_scan")).header.frame_id == "base_scan"
    assert scan_of(scan_frame([1, 2])).header.frame_id == ""


def test_a_scan_of_360_beams_with_the_name_of_its_frame_has_750_bytes_at_most() -> None:
    assert len(scan_frame([1000] * 360, name=b"base_scan")) == 749


@given(st.tuples(*[FLOATS] * 6), STAMPS)
def test_odometry_has_the_numbers_of_its_frame(values: tuple[float, ...], stamp: int) -> None:
    topic, message = published(struct.pack("<BBHI6f", 2, 0, 6, stamp, *values))
    odometry = decode(Odometry, message)
    pose, twist = odometry.pose.pose, odometry.twist.twist
    assert topic == "odom"
    assert (pose.position.x, pose.position.y, twist.linear.x, twist.linear.y, twist.angular.z) == (
        *values[:2], *values[3:],
    )  # fmt: skip
    half = values[2] / 2
    assert abs(pose.orientation.z * math.cos(half) - pose.orientation.w * math.sin(half)) < 1e-9
    assert odometry.header.stamp.secs == stamp // 1000


@given(st.tuples(*[FLOATS] * 3))
def test_a_velocity_is_the_same_both_ways(values: tuple[float, ...]) -> None:
    frame = struct.pack("<BBHI3f", 3, 0, 3, 0, *values)
    topic, message = published(frame)
    assert topic == "cmd_vel"
    assert compact_cmd_vel(message) == frame
    stamped = json.dumps({"header": {}, "twist": json.loads(message)}).encode()
    assert compact_cmd_vel(stamped) == frame


def test_a_velocity_that_is_none_is_refused() -> None:
    with pytest.raises(MalformedMessage):
        compact_cmd_vel(b'{"linear": 5}')


GOOD = [scan_frame([1, 2, 3], name=b"laser"), ODOM, struct.pack("<BBHI3f", 3, 0, 3, 0, 0.1, 0, 0.2)]


@given(st.sampled_from(GOOD), st.integers(-20, 20), st.binary(max_size=4))
def test_a_frame_that_is_cut_off_or_has_more_is_refused(frame: bytes, size: int, more: bytes) -> None:
    other = frame[:size] + more
    if is_compact(other) and len(other) != len(frame):
        with pytest.raises(MalformedMessage):
            compact_to_json(other)


@given(
    st.binary(max_size=60).map(lambda data: b"\x01" + data) | st.binary(max_size=60).map(lambda data: b"\x02" + data)
)
def test_any_bytes_are_an_operation_or_refused(frame: bytes) -> None:
    try:
        published(frame)
    except MalformedMessage as error:
        assert str(error)


@pytest.mark.parametrize(
    ("frame", "reason"),
    [
        (b"\x01\0\0", "at least 8 bytes, not 3"),
        (scan_frame([]), "needs ranges"),
        (scan_frame([1], first=math.nan), "finite angles"),
        (scan_frame([1], step=math.inf), "finite angles"),
        (scan_frame([1], name=b"\xff"), "UTF-8"),
        (scan_frame([1]) + b"x", "has 22 bytes by its head, not 23"),
        (b"\x02\1" + ODOM[2:], "byte 1"),
        (struct.pack("<BBHI6f", 2, 0, 5, 0, *[0.0] * 6), "has 6 values, not 5"),
        (struct.pack("<BBHI6f", 2, 0, 6, 0, math.nan, *[0.0] * 5), "finite numbers"),
        (struct.pack("<BBHI3f", 3, 0, 3, 0, math.inf, 0, 0), "finite numbers"),
    ],
)
def test_a_wrong_frame_is_refused_with_the_reason(frame: bytes, reason: str) -> None:
    with pytest.raises(MalformedMessage, match=reason):
        compact_to_json(frame)


@pytest.mark.parametrize("frame", [b"", b"{}", b"\xa0", b"\t{}", b"\n{}", b"\r{}", b"\0", b"\x04"])
def test_other_frames_are_not_taken_for_compact_ones(frame: bytes) -> None:
    assert not is_compact(frame)


def values_of(frame: bytes) -> Any:
    return json.loads(published(frame)[1])


def test_a_stamp_of_zero_means_now() -> None:
    assert values_of(ODOM)["header"]["stamp"] == {"secs": 0, "nsecs": 0}
