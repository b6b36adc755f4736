"""Connection headers and frames of TCPROS."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge
from ppaas.wire.ros import ros_types
from ppaas.wire.ros import tcpros as codec
from ppaas.wire.ros.tcpros import FrameReader, answered, check_peer, framed, pack_header, unpack_header

TYPES = ros_types("noetic")
KEYS = st.text(min_size=1, max_size=20).filter(lambda text: "=" not in text)


def test_a_header_is_that_of_the_specification() -> None:
    data = pack_header({"callerid": "/a", "md5sum": "*"})
    assert data == b"\x0b\0\0\0callerid=/a" + b"\x08\0\0\0md5sum=*"
    assert framed(b"ab") == b"\2\0\0\0ab"
    assert (answered(b"ab"), answered(b"no", ok=False)) == (b"\1\2\0\0\0ab", b"\0\2\0\0\0no")


@given(st.dictionaries(KEYS, st.text(max_size=50), max_size=20))
def test_headers_are_read_as_they_were_written(fields: dict[str, str]) -> None:
    assert unpack_header(pack_header(fields)) == fields


@given(st.lists(st.binary(max_size=30), max_size=10), st.integers(1, 7))
def test_frames_are_read_however_they_were_cut(frames: list[bytes], step: int) -> None:
    data, reader, taken = b"".join(map(framed, frames)), FrameReader(), []
    for start in range(0, len(data), step):
        reader.feed(data[start : start + step])
        while (frame := reader.take(30)) is not None:
            taken.append(frame)
    assert taken == frames


@pytest.mark.parametrize(
    ("data", "error", "text"),
    [
        (b"\5\0\0\0a=b", MalformedMessage, "byte 0 is cut off"),
        (b"\3\0\0\0a=b\3\0", MalformedMessage, "byte 7 is cut off"),
        (b"\3\0\0\0abc", MalformedMessage, "has no '='"),
        (b"\3\0\0\0a=\xff", MalformedMessage, "not UTF-8"),
        (bytes(codec.MAX_HEADER + 1), MessageTooLarge, "at most 262144"),
        (pack_header({f"k{one}": "" for one in range(codec.MAX_FIELDS + 1)}), MessageTooLarge, "more than 64 fields"),
    ],
)
def test_what_is_no_header_is_refused(data: bytes, error: type[InvalidInput], text: str) -> None:
    with pytest.raises(error, match=text):
        unpack_header(data)


def test_a_frame_above_the_limit_is_refused_before_it_has_arrived() -> None:
    reader = FrameReader()
    reader.feed(b"\0\0\0\1")
    with pytest.raises(MessageTooLarge, match="at most 100"):
        reader.take(100)


def test_both_sides_name_the_sum_and_the_definition_of_the_type() -> None:
    publisher = codec.publisher_header(TYPES, "/a", "/scan", "sensor_msgs/LaserScan", latching=True)
    assert (publisher["md5sum"], publisher["latching"]) == ("90c7ef2dc6895d81024acba2ac42f369", "1")
    assert "float32[] ranges" in publisher["message_definition"]
    subscriber = codec.subscriber_header(TYPES, "/a", "/scan", "sensor_msgs/LaserScan")
    assert (subscriber["topic"], subscriber["tcp_nodelay"]) == ("/scan", "1")
    server = codec.server_header(TYPES, "/a", "nav_msgs/GetMap")
    assert (server["md5sum"], server["request_type"]) == ("6cdd0a18e0aff5b0a3ca2326a89b54ff", "nav_msgs/GetMapRequest")


def test_a_peer_with_another_type_is_told_in_words() -> None:
    check_peer(TYPES, {"md5sum": "*"}, "nav_msgs/Path")
    check_peer(TYPES, {"md5sum": TYPES.md5("nav_msgs/srv/GetMap")}, "nav_msgs/GetMap", service=True)
    with pytest.raises(InvalidInput, match=r"nav_msgs/Odometry with md5sum 1234, not nav_msgs/Path with .*: build the"):
        check_peer(TYPES, {"type": "nav_msgs/Odometry", "md5sum": "1234"}, "nav_msgs/Path")
    with pytest.raises(InvalidInput, match=r"a type without a name with md5sum \(none\)"):
        check_peer(TYPES, {}, "nav_msgs/Path")
    with pytest.raises(InvalidInput, match="the node refused: no such topic"):
        check_peer(TYPES, {"error": "no such topic"}, "nav_msgs/Path")
