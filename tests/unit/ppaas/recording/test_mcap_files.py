"""MCAP files: written, copied, read, and refused where they are hostile."""

import struct
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader

from ppaas import distribution
from ppaas.errors import InvalidInput, InvalidParameter, MalformedMessage, MessageTooLarge, Unavailable
from ppaas.messages import decode
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_web_republisher import TFSubscriptionActionGoal, TFSubscriptionGoal
from ppaas.recording import reader as reading
from ppaas.recording.batches import BatchedMessage
from ppaas.recording.mcap_library import mcap_modules
from ppaas.recording.parameters import checked_globs, recorder_parameters, selects
from ppaas.recording.reader import MAGIC, McapDecoder, McapReader, decoded
from ppaas.recording.writer import McapCopy, McapFile, encoded
from ppaas.wire.ros import ros_types
from tests.support.fuzzing import EXAMPLES
from tests.support.recordings.entries import ABOUT, START, entry, mcap, read, scan, text, twist

DRIVE = (
    text("map_name", "office"),
    entry("scan", scan(1), 1),
    entry("cmd_vel", twist(), 2, up=False),
    entry("scan", scan(3), 3),
)


def test_file_is_read_back() -> None:
    reader, messages = read(mcap(*DRIVE))
    assert [message.channel.topic for message in messages] == ["/map_name", "/scan", "/cmd_vel", "/scan"]
    assert [message.sequence for message in messages] == [1, 1, 1, 2]
    assert messages[1].log_time == START + 10**9
    assert decode(LaserScan, decoded(messages[1].channel, messages[1].data)) == scan(1)
    assert reader.metadata["ppaas"]["map"] == ABOUT.map
    assert reader.attachments["robot.json"] == b'{"map":"office","model":"turtlebot2"}'
    assert not reader.cut


def test_library_mcap_reads_it() -> None:
    reader = make_reader(BytesIO(mcap(*DRIVE)), validate_crcs=True)
    found = [(channel.topic, schema.name) for schema, channel, _ in reader.iter_messages() if schema is not None]
    assert found[1:3] == [("/scan", "sensor_msgs/msg/LaserScan"), ("/cmd_vel", "geometry_msgs/msg/Twist")]
    assert reader.get_header().profile == "ros2"


def test_rosbags_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    path.write_bytes(mcap(*DRIVE))
    bag: Any
    with AnyReader([path]) as bag:
        scans: list[Any] = [bag.deserialize(raw, c.msgtype) for c, _, raw in bag.messages() if c.topic == "/scan"]
        durability = {
            connection.topic: connection.ext.offered_qos_profiles[0].durability for connection in bag.connections
        }
    assert scans[0].ranges.tolist()[:2] == [1.0, 2.5]
    assert durability["/map_name"].name == "TRANSIENT_LOCAL"
    assert durability["/scan"].name == "VOLATILE"


# -- files that were cut off, damaged or made by somebody else ---------------------------------------------------------


def test_types_have_their_names_of_ros_2() -> None:
    goal = TFSubscriptionActionGoal(TFSubscriptionGoal(["base_link"], "map"))
    _, (message,) = read(mcap(entry("tf2_web_republisher/goal", goal)))
    assert message.channel.type == "tf2_web_republisher_interfaces/msg/TFSubscriptionActionGoal"
    assert decode(TFSubscriptionActionGoal, decoded(message.channel, message.data)) == goal


def test_file_without_an_end_has_what_was_written() -> None:
    reader, messages = read(mcap(*DRIVE, finish=False))
    assert len(messages) == len(DRIVE)
    assert reader.cut


def test_every_cut_of_a_file_is_read_as_far_as_it_goes() -> None:
    whole = mcap(*DRIVE)
    counts = []
    for length in range(len(MAGIC), len(whole)):
        counts.append(len(read(whole[:length])[1]))
    assert counts[0] == 0
    assert counts == sorted(counts)
    assert counts[-1] == len(DRIVE)


def test_wrong_checksum_is_an_error() -> None:
    data = bytearray(_written(CompressionType.NONE))
    data[data.index(b"payload")] ^= 1
    with pytest.raises(MalformedMessage, match="checksum"):
        read(bytes(data))


@pytest.mark.parametrize("compression", CompressionType)
def test_all_compressions_are_read(compression: CompressionType) -> None:
    _, messages = read(_written(compression))
    assert [message.data for message in messages] == [b"payload"]
    assert messages[0].channel.type == ""


def test_messages_of_a_chunk_are_sorted_by_time() -> None:
    stream = BytesIO()
    writer: Any = Writer(stream)
    writer.start()
    channel = writer.register_channel("/a", "json", 0)
    for at in (30, 10, 20):
        writer.add_message(channel, at, b"{}", at)
    writer.finish()
    assert [message.log_time for message in read(stream.getvalue())[1]] == [10, 20, 30]


def test_other_files_are_refused() -> None:
    with pytest.raises(MalformedMessage, match="not an MCAP file"):
        McapReader(BytesIO(b"#ROSBAG V2.0\n" + b"\0" * 100))


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE])
def test_decompression_bomb_is_refused_in_little_memory(
    compression: CompressionType, monkeypatch: pytest.MonkeyPatch
) -> None:
    bomb = _written(compression, bytes(1 << 20))
    monkeypatch.setattr(reading, "MOST_CHUNK", 1 << 16)
    with pytest.raises(MessageTooLarge, match="chunk"):
        read(bomb)


def test_chunk_that_is_larger_than_it_says_is_refused() -> None:
    data = bytearray(_written(CompressionType.ZSTD, bytes(1 << 20)))
    size = data.index(struct.pack("<Q", (1 << 20) + _overhead()))
    data[size : size + 8] = struct.pack("<Q", 100)
    with pytest.raises(MalformedMessage, match="101 bytes or more, and not 100"):
        read(bytes(data))


def test_huge_record_is_refused_before_it_is_read() -> None:
    with pytest.raises(MessageTooLarge, match="at most"):
        read(MAGIC + struct.pack("<BQ", reading.CHUNK, 1 << 62))


def test_huge_attachment_is_skipped() -> None:
    reader, messages = read(MAGIC + struct.pack("<BQ", reading.ATTACHMENT, 1 << 62) + b"x" * 1000)
    assert (messages, reader.cut) == ([], True)


def test_number_of_channels_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MOST_CHANNELS", 3)
    with pytest.raises(MessageTooLarge, match="channels"):
        read(mcap(*(text(f"t{number}", "") for number in range(5))))


def test_unknown_types_are_counted_and_left_out() -> None:
    stream = BytesIO()
    writer: Any = Writer(stream)
    writer.start()
    schema = writer.register_schema("acme_msgs/msg/Anvil", "ros2msg", b"float64 weight")
    for topic, encoding in (("/anvil", "cdr"), ("/odd", "protobuf")):
        writer.add_message(writer.register_channel(topic, encoding, schema), 1, b"\0" * 12, 1)
    writer.finish()
    decoder = McapDecoder()
    assert [decoder.json(message) for message in read(stream.getvalue())[1]] == [None, None]
    assert sorted(reason.split(":")[0] for reason in decoder.skipped) == ["/anvil", "/odd"]


GOOD = mcap(*DRIVE)


@given(st.integers(0, len(GOOD) - 1), st.binary(min_size=1, max_size=12), st.integers(0, 20))
def test_damaged_files_end_in_typed_errors(at: int, patch: bytes, cut: int) -> None:
    damaged = GOOD[:at] + patch + GOOD[at + len(patch) :]
    decoder = McapDecoder()
    try:
        for message in McapReader(BytesIO(damaged[: len(damaged) - cut])).messages():
            decoder.json(message)
    except InvalidInput:
        pass


# -- copies ------------------------------------------------------------------------------------------------------------


def test_segments_become_one_file_without_what_they_repeat() -> None:
    first, second = mcap(*DRIVE), mcap(*DRIVE[1:], finish=False)
    repeated = _with_repeated(text("map_name", "office", 9), entry("scan", scan(9), 9))
    output = BytesIO()
    copied = McapCopy(output, lambda topic: topic != "cmd_vel").copy(map(BytesIO, (first, second, repeated)))
    reader, messages = read(output.getvalue())
    assert [message.channel.topic for message in messages] == ["/map_name", *["/scan"] * 5]
    assert copied == (6, 1)
    assert not reader.cut
    assert reader.metadata["ppaas"]["robot"] == "tb1"
    make_reader(BytesIO(output.getvalue()), validate_crcs=True).get_summary()


def test_copy_of_nothing_is_a_file() -> None:
    output = BytesIO()
    assert McapCopy(output, lambda _: True).copy([BytesIO(b"")]) == (0, 1)
    assert read(output.getvalue())[1] == []


def _with_repeated(repeated: BatchedMessage, other: BatchedMessage) -> bytes:
    stream = BytesIO()
    file = McapFile(stream, ABOUT)
    file.add(encoded(repeated), log_time=START)
    file.add(encoded(other))
    file.finish()
    return stream.getvalue()


def _written(compression: CompressionType, payload: bytes = b"payload") -> bytes:
    stream = BytesIO()
    writer: Any = Writer(stream, compression=compression)
    writer.start()
    writer.add_message(writer.register_channel("/a", "json", 0), 5, payload, 5)
    writer.finish()
    return stream.getvalue()


def _overhead() -> int:
    """Return the size of the channel and the head of the message in the chunk of `_written`."""
    channel = 9 + 2 + 2 + (4 + 2) + (4 + 4) + 4
    return channel + 9 + 22


def test_the_writer_and_its_records_are_returned() -> None:
    writer, records = mcap_modules()
    assert (writer.__name__, records.__name__) == ("mcap.writer", "mcap.records")


def test_a_library_that_cannot_flush_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "1.4.0" if name == "mcap" else version(name))
    with pytest.raises(Unavailable, match=r"mcap 1\.4\.0 \(needed: >=1\.5\)"):
        mcap_modules()


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


def test_defaults_record_nothing() -> None:
    assert recorder_parameters({}).ring_seconds == 0.0
    assert recorder_parameters({"ring_minutes": 5}).ring_seconds == 300.0


@pytest.mark.parametrize(
    "given",
    [
        {"ring_minutes": -1},
        {"ring_minutes": 61},
        {"max_mb": 0},
        {"max_mb": 513},
        {"topics": []},
        {"topics": ["a b"]},
        {"topics": ["x"] * 65},
        {"rings": 1},
        [],
    ],
)
def test_invalid_parameters_are_refused(given: object) -> None:
    with pytest.raises(InvalidParameter, match="known: max_mb, ring_minutes, topics"):
        recorder_parameters(given)


def test_star_leaves_heavy_topics_out() -> None:
    assert selects(("*",), "scan")
    assert not selects(("*",), "camera/depth/image_raw")
    assert selects(("*", "camera/depth/*"), "camera/depth/image_raw")
    assert selects(("octomap_full",), "octomap_full")
    assert not selects(("scan",), "odom")


def test_globs_may_have_a_leading_slash() -> None:
    assert checked_globs(("/scan", "tf*")) == ("scan", "tf*")
    with pytest.raises(InvalidParameter, match="topics to record"):
        checked_globs(())
