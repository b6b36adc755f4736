"""Records of bags of ROS 1. Bags as tools leave them are read in tests/unit/robots/recordings/test_bag.py."""

import struct
from io import BytesIO

import pytest

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge
from ppaas.recording.ros1_bags import MAGIC, MOST_DATA, Ros1BagReader


def fields(**values: bytes) -> bytes:
    lines = [name.encode() + b"=" + value for name, value in values.items()]
    return b"".join(struct.pack("<I", len(line)) + line for line in lines)


def record(data: bytes = b"", **values: bytes) -> bytes:
    head = fields(**values)
    return struct.pack("<I", len(head)) + head + struct.pack("<I", len(data)) + data


def connection(number: int, topic: bytes = b"/scan") -> bytes:
    described = fields(type=b"std_msgs/String", md5sum=b"*", message_definition=b"string data")
    return record(described, op=b"\x07", conn=struct.pack("<I", number), topic=topic)


def message(number: int, data: bytes = b"x") -> bytes:
    return record(data, op=b"\x02", conn=struct.pack("<I", number), time=struct.pack("<II", 3, 5))


def reader(*records: bytes) -> Ros1BagReader:
    return Ros1BagReader(BytesIO(MAGIC + b"".join(records)))


def test_messages_outside_chunks_are_read() -> None:
    (found,) = reader(connection(7), message(7)).messages()
    assert (found.log_time, found.data, found.channel.topic) == (3 * 10**9 + 5, b"x", "/scan")
    assert (found.channel.type, found.channel.encoding, found.channel.definition) == (
        "std_msgs/String",
        "ros1",
        b"string data",
    )


def test_a_connection_may_be_repeated_with_another_topic() -> None:
    found = reader(connection(1), message(1), connection(1, b"/other"), message(1)).messages()
    assert [each.channel.topic for each in found] == ["/scan", "/other"]


def test_a_bag_with_chunks_is_whole_if_it_is_indexed() -> None:
    chunk = record(connection(1) + message(1), op=b"\x05", compression=b"none", size=bytes(4))
    for end, cut in ((b"", True), (record(op=b"\x06"), False)):
        bag = reader(chunk, end)
        assert len(list(bag.messages())) == 1
        assert bag.cut is cut


def test_a_compressed_chunk_that_was_not_finished_is_the_end() -> None:
    bag = reader(connection(1), message(1), record(op=b"\x05", compression=b"lz4", size=bytes(4)), b"\x04\x22\x4d\x18")
    assert len(list(bag.messages())) == 1
    assert bag.cut


@pytest.mark.parametrize(
    ("records", "error", "why"),
    [
        ((message(1),), MalformedMessage, "names connection 1, which is missing"),
        ((record(nothing=b"1"),), MalformedMessage, "no field op"),
        ((record(op=b"\x02"),), MalformedMessage, "no field conn"),
        ((record(op=b"\x03", encryptor=b"rosbag/AesCbcEncryptor"),), MalformedMessage, "is encrypted"),
        (
            (record(b"x", op=b"\x05", compression=b"zip", size=bytes(4)),),
            MalformedMessage,
            "unknown compression b'zip'",
        ),
        ((record(b"bad", op=b"\x05", compression=b"bz2", size=b"\x01\0\0\0"),), MalformedMessage, "be decompressed"),
        ((struct.pack("<I", 9) + bytes(9),), MalformedMessage, "header of a record is damaged"),
        ((b"\xff\xff\xff\x7f",), MessageTooLarge, "a record of 2147483647 bytes"),
        (
            (record(b"x", op=b"\x05", compression=b"lz4", size=struct.pack("<I", MOST_DATA + 1)),),
            MessageTooLarge,
            "a chunk of",
        ),
    ],
)
def test_damaged_records_are_refused(records: tuple[bytes, ...], error: type[InvalidInput], why: str) -> None:
    with pytest.raises(error, match=why):
        list(reader(*records).messages())
