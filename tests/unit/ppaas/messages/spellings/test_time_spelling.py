"""Times in both spellings: converted as text with the same result as by parsing, and accepted in all messages."""

import json

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.spelling import to_ros1, to_ros2
from ppaas.messages.base.std_msgs import Duration, Header, Time
from ppaas.messages.sensor_msgs import LaserScan

WORDS = ["secs", "nsecs", "sec", "nanosec", "stamp", '"secs', 'a"secs', '\\"secs', '"secs":', '"sec": 1', "\\"]
TEXT = (
    st.sampled_from(WORDS) | st.text(max_size=5) | st.builds(str.__add__, st.sampled_from(WORDS), st.text(max_size=3))
)
VALUES = st.recursive(
    st.none() | st.integers() | TEXT,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=4),
    max_leaves=12,
)
SEPARATORS = st.sampled_from([(",", ":"), (", ", ": "), (" ,\n", "\t : ")])


def respelled(value: object, names: dict[str, str]) -> object:
    """Slow twin: rename the keys of parsed JSON."""
    if isinstance(value, dict):
        return [(names.get(key, key), respelled(inner, names)) for key, inner in value.items()]
    return [respelled(inner, names) for inner in value] if isinstance(value, list) else value


def pairs(payload: bytes) -> object:
    """Parse JSON with objects as lists of pairs, since renaming may make two keys equal."""
    return json.loads(payload, object_pairs_hook=list)


@given(VALUES, SEPARATORS)
def test_respelling_the_text_equals_respelling_the_keys(value: object, separators: tuple[str, str]) -> None:
    payload = json.dumps(value, separators=separators).encode()
    assert pairs(to_ros2(payload)) == respelled(value, {"secs": "sec", "nsecs": "nanosec"})
    assert pairs(to_ros1(payload)) == respelled(value, {"sec": "secs", "nanosec": "nsecs"})


STAMPS = st.builds(Time, st.integers(-(2**31), 2**32), st.integers(0, 10**9 - 1))
SCANS = st.builds(
    LaserScan,
    st.builds(Header, st.integers(0, 9), STAMPS, TEXT.filter(str.isprintable)),
    *[st.just(0.5)] * 5,
    st.lists(st.none() | st.floats(0, 30), max_size=5),
)


@given(SCANS)
def test_a_message_is_read_in_either_spelling(scan: LaserScan) -> None:
    payload = encode(scan)
    assert decode(LaserScan, payload) == scan
    assert decode(LaserScan, to_ros2(payload)) == scan
    assert to_ros1(to_ros2(payload)) == payload


@pytest.mark.parametrize("wrap", [bytes, bytes.decode, msgspec.Raw])
def test_bytes_text_and_raw_are_read_in_either_spelling(wrap) -> None:
    assert decode(Header, wrap(b'{"stamp": {"sec": 1, "nanosec": 5}}')).stamp == Time(1, 5)
    assert decode(Duration, wrap(b'{"sec": 2, "nanosec": 500000000}')).seconds() == 2.5


def test_nested_stamps_in_mixed_spellings_are_read() -> None:
    one, two = '{"secs": 1, "nsecs": 2}', '{"sec": 3, "nanosec": 4}'
    status = '{"goal_id": {"id": "a", "stamp": %s}, "status": 1}'
    array = decode(GoalStatusArray, f'{{"status_list": [{status % one}, {status % two}]}}')
    assert [s.goal_id.stamp for s in array.status_list] == [Time(1, 2), Time(3, 4)]


@pytest.mark.parametrize(
    ("payload", "text"),
    [
        (b'{"stamp": {"seconds": 1}}', r"Time has no field 'seconds' at `\$\.stamp`; its fields are: secs, nsecs"),
        (b'{"stamp": {"sec": "now"}}', r"`\$\.stamp\.secs`"),
        (b'{"stamp": {"sec": 1}, "seq": "x"}', r"`\$\.seq`"),
        (b'{"stamp": {"sec": 1}', "not JSON"),
        (b'{"stamp": {"sec": 1}, "frame_id": "\xff"}', "not JSON"),
    ],
)
def test_a_stamp_with_other_keys_is_refused(payload: bytes, text: str) -> None:
    with pytest.raises(MalformedMessage, match=text):
        decode(Header, payload)
