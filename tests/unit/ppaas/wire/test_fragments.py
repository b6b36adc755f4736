"""Frames in fragments."""

import json
import random
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, QuotaExceeded
from ppaas.wire import fragments
from ppaas.wire.fragments import MAX_FRAGMENTS, MAX_OPEN, FragmentAssembler, in_fragments, size_of
from ppaas.wire.operations import CallService, Fragment, Publish, RefusedOperation, Subscribe
from ppaas.wire.rosbridge import RosbridgeSession


def split(text: str, size: int, identity: Any = "f") -> list[Fragment]:
    pieces = [text[begin : begin + size] for begin in range(0, len(text), size)]
    return [Fragment(piece, number, len(pieces), identity) for number, piece in enumerate(pieces)]


@given(st.text(min_size=1), st.integers(1, 9), st.randoms(use_true_random=False))
def test_a_frame_is_complete_with_its_last_fragment_in_any_order(text: str, size: int, dice: random.Random) -> None:
    assembler, parts = FragmentAssembler(), split(text, size)
    dice.shuffle(parts)
    found = [assembler.add(part) for part in parts]
    assert found[-1] == text
    assert set(found[:-1]) <= {None}


def test_fragments_of_several_frames_may_alternate() -> None:
    assembler = FragmentAssembler()
    pairs = zip(split("first", 1, 1), split("other", 1, "1"), strict=True)
    found = [assembler.add(part) for pair in pairs for part in pair]
    assert found[-2:] == ["first", "other"]


@pytest.mark.parametrize(
    "fragment",
    [Fragment("a", 0, 1), Fragment("a", -1, 2, 1), Fragment("a", 2, 2, 1), Fragment("a", 0, MAX_FRAGMENTS + 1, 1)],
)
def test_an_invalid_fragment_is_refused(fragment: Fragment) -> None:
    with pytest.raises(InvalidInput):
        FragmentAssembler().add(fragment)


def test_another_total_ends_the_frame() -> None:
    assembler = FragmentAssembler()
    assembler.add(Fragment("a", 0, 3, 1))
    with pytest.raises(InvalidInput, match="same total"):
        assembler.add(Fragment("b", 1, 2, 1))
    assert assembler.add(Fragment("a", 0, 2, 1)) is None
    assert assembler.add(Fragment("b", 1, 2, 1)) == "ab"


def test_incomplete_frames_are_limited_in_number_and_size(monkeypatch: pytest.MonkeyPatch) -> None:
    assembler = FragmentAssembler()
    for number in range(3 * MAX_OPEN):
        assembler.add(Fragment("a", 0, 2, number))
    assert len(assembler._open) == MAX_OPEN
    monkeypatch.setattr(fragments, "MAX_SIZE", MAX_OPEN)
    with pytest.raises(QuotaExceeded):
        assembler.add(Fragment("b", 0, 2, "more"))
    assert assembler._open == {}


def test_a_frame_in_fragments_is_an_operation() -> None:
    session, frame = RosbridgeSession(), json.dumps({"op": "publish", "topic": "/a", "msg": {"x": 1}})
    sent = [
        {"op": "fragment", "id": 5, "data": part.data, "num": part.num, "total": part.total} for part in split(frame, 9)
    ]
    found = [session.receive(json.dumps(part)) for part in sent]
    assert isinstance(found[-1], Publish) and bytes(found[-1].msg) == b'{"x": 1}'
    assert all(isinstance(operation, Fragment) for operation in found[:-1])


def test_fragments_within_fragments_are_refused() -> None:
    inner = json.dumps({"op": "fragment", "id": "i", "data": "{}", "num": 0, "total": 1})
    outer = json.dumps({"op": "fragment", "id": "o", "data": inner, "num": 0, "total": 1})
    refused = RosbridgeSession().receive(outer)
    assert isinstance(refused, RefusedOperation)
    assert (type(refused.error), refused.id) == (MalformedMessage, "o")


# -- frames to clients -------------------------------------------------------------------------------------------------


@given(st.text(min_size=1), st.integers(1, 9))
def test_a_long_frame_is_cut_into_fragments_that_join_to_it(text: str, size: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fragments, "LEAST_SIZE", 1)
        parts = in_fragments(text.encode(), size, "f")
    if len(parts) == 1:
        assert parts == [text.encode()]
        return
    assembler, read = FragmentAssembler(), [msgspec.json.decode(part, type=Fragment) for part in parts]
    assert all(len(part.data) <= size for part in read)
    assert [assembler.add(part) for part in read] == [None] * (len(parts) - 1) + [text]


@pytest.mark.parametrize(("length", "size", "count"), [
    (1024, 1, 1), (1025, 1, 2), (4096, 1024, 4), (4096, 4096, 1), (4096, 4095, 2), (4096, 0, 1), (1 << 22, 1024, 1000),
    (1 << 22, 1 << 20, 4), (100, 2**31, 1),
])  # fmt: skip
def test_fragments_are_neither_tiny_nor_many(length: int, size: int, count: int) -> None:
    assert len(in_fragments(b"x" * length, size, "f")) == count


@pytest.mark.parametrize(("given_size", "size"), [(None, 0), (0, 0), (-5, 0), (2048.0, 2048), (2147483647, 2147483647)])
def test_the_size_of_fragments_is_a_number_from_zero(given_size: float | None, size: int) -> None:
    assert size_of(Subscribe("map", fragment_size=given_size)) == size
    assert size_of(CallService("static_map", fragment_size=given_size)) == size
