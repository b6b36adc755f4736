"""Messages of bags as objects."""

from pathlib import Path

import pytest

from ppaas.recording.reader import Channel, Message
from robots.recordings.bag import Bag
from robots.recordings.bag_objects import BagObjects, full_type
from tests.support.recordings.bags import SCAN, make_bag, room


@pytest.mark.parametrize("definition", ["kept", "missing", "nonsense", "damaged"])
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_messages_are_read_by_the_definition_in_the_bag_or_by_the_release(
    tmp_path: Path, kind: str, definition: str
) -> None:
    messages = [each for each in Bag(make_bag(tmp_path / "drive", kind, 1)).messages() if each.channel.topic == "/scan"]
    (message,) = messages
    text = {"kept": message.channel.definition, "missing": b"", "nonsense": b"uint99 @@", "damaged": b"float32 ranges"}[
        definition
    ]
    objects = BagObjects()
    found = objects.read(message._replace(channel=message.channel._replace(definition=text)))
    assert found is not None and found.ranges.tolist() == room(-0.5).tolist()
    assert not objects.damaged


def test_types_that_the_release_lacks_are_read() -> None:
    channel = Channel("/old", "cdr", "old_msgs/Pair", "ros2msg", b"uint8 first\nfloat32 second\n", {})
    found = BagObjects().read(Message(channel, 0, 0, 0, b"\x00\x01\x00\x00\x07\x00\x00\x00\x00\x00\x80\x3f"))
    assert (found.first, found.second) == (7, 1.0)


@pytest.mark.parametrize(
    "name",
    [
        "sensor_msgs/LaserScan",
        "sensor_msgs/msg/LaserScan",
        "sensor_msgs::msg::dds_::LaserScan_",
        "sensor_msgs::msg::LaserScan",
    ],
)
def test_types_are_known_by_their_names_in_ros_1_ros_2_and_dds(name: str) -> None:
    assert full_type(name) == SCAN


def test_idl_is_read() -> None:
    text = b"=" * 80 + b"\nIDL: a/msg/B\nmodule a { module msg { struct B { long first; }; }; };\n"
    channel = Channel("/idl", "cdr", "a/msg/B", "ros2idl", text, {})
    assert BagObjects().read(Message(channel, 0, 0, 0, b"\x00\x01\x00\x00\x05\x00\x00\x00")).first == 5


def test_damaged_messages_are_counted() -> None:
    objects = BagObjects()
    assert objects.read(Message(Channel("/scan", "cdr", SCAN, "", b"", {}), 0, 0, 0, b"\x00\x01\x00\x00\x01")) is None
    assert objects.damaged == {"/scan": 1}
