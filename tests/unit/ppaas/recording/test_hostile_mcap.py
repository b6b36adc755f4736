"""Files of MCAP changed at random, compressed or not: whatever is in them, the error is a typed one."""

from io import BytesIO
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from ppaas.errors import InvalidInput
from ppaas.recording.reader import McapDecoder, McapReader
from ppaas.recording.writer import McapCopy
from ppaas.wire.ros import ros_types
from tests.support.fuzzing import EXAMPLES
from tests.support.recordings.entries import entry, mcap, read, scan, text, twist

DRIVE = (
    text("map_name", "office"),
    entry("scan", scan(1), 1),
    entry("cmd_vel", twist(), 2, up=False),
    entry("scan", scan(3), 3),
)


def plain(data: bytes) -> bytes:
    """Return a file without compression and checksums, so that changes reach the records and the messages."""
    stream = BytesIO()
    writer: Any = Writer(stream, compression=CompressionType.NONE, enable_crcs=False)
    writer.start()
    for message in read(data)[1]:
        of = message.channel
        schema = writer.register_schema(of.type, of.schema_encoding, of.definition)
        channel = writer.register_channel(of.topic, of.encoding, schema, of.metadata)
        writer.add_message(channel, message.log_time, message.data, message.publish_time)
    writer.finish()
    return stream.getvalue()


def of_ros_1() -> bytes:
    """Return a file of ROS 1, likewise."""
    types, stream = ros_types("noetic"), BytesIO()
    writer: Any = Writer(stream, compression=CompressionType.NONE, use_chunking=False)
    writer.start(profile="ros1")
    for kind in ("sensor_msgs/LaserScan", "tf2_msgs/TFMessage"):
        schema = writer.register_schema(kind, "ros1msg", types.definition(kind).encode())
        channel = writer.register_channel("/a", "ros1", schema)
        writer.add_message(channel, 1, types.encode(kind, {}), 1)
    writer.finish()
    return stream.getvalue()


FILES = (mcap(*DRIVE), plain(mcap(*DRIVE)), of_ros_1(), mcap(*DRIVE, finish=False))
CHANGES = st.lists(st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.binary(min_size=1, max_size=9)), max_size=4)


@settings(max_examples=EXAMPLES)
@given(st.sampled_from(FILES), CHANGES, st.floats(0.0, 1.0))
def test_hostile_bytes_are_read_or_refused(file: bytes, changes: list[tuple[float, bytes]], kept: float) -> None:
    data = bytearray(file)
    for place, patch in changes:
        at = int(place * len(data))
        data[at : at + len(patch)] = patch
    data = data[: len(data) if kept > 0.5 else int(2.0 * kept * len(data))]
    decoder = McapDecoder()
    try:
        for message in McapReader(BytesIO(data)).messages():
            decoder.json(message)
    except InvalidInput as error:
        assert str(error)
    output = BytesIO()
    copied = McapCopy(output, lambda _: True).copy([BytesIO(data)])
    assert len(read(output.getvalue())[1]) == copied.messages  # what is copied is a good file
