"""Forwarders: messages as the bytes of ROS 1."""

import json
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MessageTooLarge, PPaaSError
from ppaas.wire.rapyuta import forwarder
from ppaas.wire.rapyuta.message_codec import Forwarder


def test_a_message_is_its_serialization_compressed() -> None:
    twist = {"linear": {"x": 0.5, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -1.0}}
    part = Forwarder("geometry_msgs/Twist").write(json.dumps(twist).encode())
    assert struct.unpack("<6d", zlib.decompress(part)) == (0.5, 0.0, 0.0, 0.0, 0.0, -1.0)
    assert json.loads(Forwarder("geometry_msgs/Twist").read(part)) == twist


def test_a_request_of_a_service_is_one_too() -> None:
    codec = Forwarder("nav_msgs/srv/GetPlan_Request")
    assert json.loads(codec.read(codec.write(b'{"tolerance": 0.5}')))["tolerance"] == 0.5


@pytest.mark.parametrize("name", ["my_msgs/Lamp", "nav_msgs/srv/Nothing_Request"])
def test_unknown_types_need_a_converter(name: str) -> None:
    with pytest.raises(InvalidInput, match="use a converter"):
        Forwarder(name)


@pytest.mark.parametrize(
    "message", [{}, "x", None, b"", b"not zlib", zlib.compress(b"short"), zlib.compress(bytes(48))[:-6]]
)
def test_other_parts_are_refused(message: object) -> None:
    with pytest.raises(InvalidInput):
        Forwarder("geometry_msgs/Twist").read(message)


def test_a_bomb_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forwarder, "MAX_SERIALIZED", 1000)
    with pytest.raises(MessageTooLarge):
        Forwarder("geometry_msgs/Twist").read(zlib.compress(bytes(100_000)))


@given(st.binary(max_size=200), st.booleans())
def test_any_bytes_are_read_or_refused(data: bytes, compressed: bool) -> None:
    codec = Forwarder("sensor_msgs/LaserScan")
    try:
        codec.read(zlib.compress(data) if compressed else data)
    except PPaaSError as error:
        assert str(error)
