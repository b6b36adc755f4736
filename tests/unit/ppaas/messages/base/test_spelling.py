"""Spelling of messages: times of ROS 1 and ROS 2, and JSON as Python's parser takes it, within bounds."""

import json
import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.spelling import (
    MAX_OBJECTS,
    MAX_TOLERATED,
    MAX_VALUES,
    read_json,
    split_json,
    to_ros1,
    to_ros2,
    to_standard_json,
)
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


ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


def finite(value: object) -> object:
    """Slow twin: replace numbers that are not finite by None."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@given(ANY_JSON, st.booleans())
def test_what_python_writes_is_read_with_none_for_numbers_that_are_not_finite(value: object, ascii_only: bool) -> None:
    text = json.dumps(value, ensure_ascii=ascii_only).encode()
    assert read_json(text) == finite(value)
    assert msgspec.json.decode(to_standard_json(text)) == finite(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("\ufeff[1]", [1]), ("[1e400, -1e400]", [None, None]), ('"a\tb\n"', "a\tb\n"), (b"[NaN]", [None]),
        ('{"a": 1, "a": Infinity}', {"a": None}), ("[12345678901234567890]", [12345678901234567890]),
    ],
)  # fmt: skip
def test_what_the_standard_forbids_and_clients_send_is_read(text: str | bytes, value: object) -> None:
    assert msgspec.json.decode(to_standard_json(text)) == value


@pytest.mark.parametrize(
    "text",
    [
        "", "{", "[1,]", "{'a': 1}", "nan", "[1] [2]", b"\xff", '"\\ud800"', "[NaN, " + "9" * 5000 + "]", "[" * 100_000,
        "[NaN" + ",[]" * MAX_OBJECTS + "]", "[NaN" + ",1" * (MAX_VALUES + 1) + "]",
        "[NaN" + ',""' * 2 * MAX_OBJECTS + "]",
        "[NaN" + " " * MAX_TOLERATED + "]",
    ],
    ids=range(14),
)  # fmt: skip
def test_anything_else_is_malformed(text: str | bytes) -> None:
    with pytest.raises(MalformedMessage):
        to_standard_json(text)


@given(st.lists(st.dictionaries(st.text(), ANY_JSON, max_size=3), max_size=6), st.sampled_from(["", "\n", " \t\r\n"]))
def test_texts_one_after_the_other_are_split(values: list[object], between: str) -> None:
    texts = [json.dumps(value) for value in values]
    assert split_json(between.join(texts), 6) == texts


@pytest.mark.parametrize("text", ["{}{", "{},{}", "{}]", "{}" * 7, "[" * 100_000, "{}" + " " * MAX_TOLERATED])
def test_what_cannot_be_split_has_no_parts(text: str) -> None:
    assert split_json(text, 6) == []
