"""Binary parts of messages."""

import json
import random
from typing import Any
from uuid import uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.errors import InvalidInput, MessageTooLarge, PPaaSError, QuotaExceeded
from ppaas.wire.rapyuta.part_assembler import (
    MAX_BYTES,
    MAX_OBJECTS,
    MAX_PARTS,
    MAX_TEXT,
    MAX_WAITING,
    TIMEOUT,
    PartAssembler,
    with_references,
)

UID, OTHER = "0123456789abcdef" * 2, "f" * 32


def _frame(uid: str, data: bytes) -> bytes:
    return uid.encode() + data


def test_a_message_without_parts_is_complete() -> None:
    message = {"type": "CC", "data": {"containerTag": "c1"}}
    assert PartAssembler().take_text(json.dumps(message)) == message


def test_a_part_is_put_where_its_uuid_is() -> None:
    parts = PartAssembler()
    assert parts.take_text(json.dumps({"data": {"msg": {"image*": UID, "width": 1}}})) is None
    assert parts.take_binary(_frame(UID, b"\xff\0")) == {"data": {"msg": {"image": b"\xff\0", "width": 1}}}
    assert parts.waiting == 0


def test_parts_may_come_first_and_in_any_order() -> None:
    parts = PartAssembler()
    assert parts.take_binary(_frame(OTHER, b"2")) is None
    assert parts.take_text(json.dumps({"a*": [UID, OTHER], "b": [{"c": 1}]})) is None
    assert parts.take_binary(_frame(UID, b"1")) == {"a": [b"1", b"2"], "b": [{"c": 1}]}


def test_a_whole_message_may_be_a_part() -> None:
    parts = PartAssembler()
    parts.take_text(json.dumps({"data": {"msg*": UID}}))
    assert parts.take_binary(_frame(UID, b"x")) == {"data": {"msg": b"x"}}


def test_all_parts_before_the_message_complete_it() -> None:
    parts = PartAssembler()
    parts.take_binary(_frame(UID, b"x"))
    assert parts.take_text(json.dumps({"a*": UID})) == {"a": b"x"}
    assert parts.waiting == 0


def test_what_is_incomplete_is_dropped_after_a_minute() -> None:
    clock = ManualClock()
    parts = PartAssembler(clock)
    parts.take_text(json.dumps({"a*": UID, "b*": OTHER}))
    clock.advance(TIMEOUT - 1)
    parts.take_binary(_frame(OTHER, b""))  # each part extends the time of its message
    clock.advance(TIMEOUT - 1)
    assert parts.take_binary(_frame(UID, b"")) == {"a": b"", "b": b""}
    parts.take_text(json.dumps({"a*": UID}))
    clock.advance(TIMEOUT + 1)
    assert parts.take_binary(_frame(UID, b"late")) is None
    clock.advance(TIMEOUT + 1)
    assert parts.take_text(json.dumps({"a*": UID})) is None
    assert parts.waiting == 1


@pytest.mark.parametrize(
    "text", ['{"a*": "x"}', '{"a*": 5}', '{"a*": [1]}', "[]", "null", "{", '{"a*": "' + "g" * 32 + '"}']
)
def test_references_that_are_no_uuids_are_refused(text: str) -> None:
    with pytest.raises(InvalidInput):
        PartAssembler().take_text(text)


@pytest.mark.parametrize("frame", [b"", b"short", b"\xff" * 40])
def test_binary_frames_without_a_uuid_are_refused(frame: bytes) -> None:
    with pytest.raises(InvalidInput, match="uuid"):
        PartAssembler().take_binary(frame)


def test_nested_messages_are_bounded() -> None:
    with pytest.raises(InvalidInput, match="levels"):
        PartAssembler().take_text('{"a":' * 100 + "1" + "}" * 100)


@pytest.mark.parametrize("text", ['{"a":"' + "x" * MAX_TEXT + '"}', '{"a":[' + "[]," * MAX_OBJECTS + "[]]}"])
def test_texts_are_bounded(text: str) -> None:
    with pytest.raises(MessageTooLarge, match="binary part"):
        PartAssembler().take_text(text)


def test_a_message_has_a_limited_number_of_parts() -> None:
    text = json.dumps({"a*": [uuid4().hex for _ in range(MAX_PARTS + 1)]})
    with pytest.raises(QuotaExceeded):
        PartAssembler().take_text(text)


def test_the_oldest_of_too_many_incomplete_messages_is_dropped() -> None:
    parts = PartAssembler()
    uids = [uuid4().hex for _ in range(MAX_WAITING + 1)]
    for uid in uids:
        parts.take_text(json.dumps({"a*": uid}))
    assert parts.take_binary(_frame(uids[0], b"")) is None
    assert parts.take_binary(_frame(uids[1], b"")) == {"a": b""}


def test_parts_that_wait_have_a_limited_size() -> None:
    parts = PartAssembler()
    half = bytes(MAX_BYTES // 2 + 1)
    parts.take_binary(_frame(UID, half))
    with pytest.raises(QuotaExceeded, match="MiB"):
        parts.take_binary(_frame(OTHER, half))
    assert parts.waiting == 0


def test_infinity_as_python_2_writes_it_is_null() -> None:
    assert PartAssembler().take_text('{"ranges": [1.0, Infinity, NaN]}') == {"ranges": [1.0, None, None]}


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.text(max_size=8) | st.binary(max_size=8),
    lambda inner: (
        st.lists(inner.filter(lambda value: not isinstance(value, bytes | list)), max_size=3)
        | st.lists(st.binary(max_size=4), min_size=1, max_size=3)
        | st.dictionaries(st.text("abc", min_size=1, max_size=3), inner, max_size=3)
    ),
    max_leaves=12,
)


@given(st.dictionaries(st.text("abc", min_size=1, max_size=3), _VALUES, max_size=4), st.randoms())
def test_any_message_arrives_as_it_was_sent(message: dict[str, Any], chance: random.Random) -> None:
    value, frames = with_references(message)
    order: list[str | bytes] = [json.dumps(value), *frames]
    chance.shuffle(order)
    parts = PartAssembler()
    taken = [parts.take_text(one) if isinstance(one, str) else parts.take_binary(one) for one in order]
    assert [one for one in taken if one is not None] == [message]
    assert taken[-1] == message


@given(st.lists(st.text(max_size=30) | st.binary(max_size=40), max_size=5))
def test_any_frames_are_taken_or_refused(frames: list[str | bytes]) -> None:
    parts = PartAssembler()
    for frame in frames:
        try:
            parts.take_text(frame) if isinstance(frame, str) else parts.take_binary(frame)
        except PPaaSError as error:
            assert str(error)
