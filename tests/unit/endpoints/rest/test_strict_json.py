"""Strict JSON: what two parsers could read differently is rejected, and a body costs no more than its size.

Other members of the kind "a body that stops the loop": a key given twice among many (quadratic search), many small
objects and lists (garbage collection), deep nesting (recursion), long numbers, a body read before its caller is known,
and a list with a fault in each item (`tests/unit/endpoints/test_app_bodies.py`).
"""

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from endpoints.rest import strict_json
from endpoints.rest.strict_json import MAX_CONTAINERS, MAX_DEPTH, MAX_KEYS, parse
from ppaas.errors import MalformedMessage, MessageTooLarge, PPaaSError


def test_duplicate_keys_are_refused_at_any_depth() -> None:
    assert parse(b'{"a": {"b": 1}, "c": {"b": 1}}') == {"a": {"b": 1}, "c": {"b": 1}}
    with pytest.raises(MalformedMessage, match="'b' twice"):
        parse(b'{"a": [{"b": 1, "c": 2, "b": 1}]}')


class CountedName(str):
    """Name that counts how often it is hashed or compared."""

    used = 0

    def __hash__(self) -> int:
        CountedName.used += 1
        return super().__hash__()

    def __eq__(self, other: object) -> bool:
        CountedName.used += 1
        return super().__eq__(other)


def test_a_repeated_key_is_found_in_one_pass() -> None:
    names = [*map(str, range(MAX_KEYS - 1)), str(MAX_KEYS - 2)]
    CountedName.used = 0
    with pytest.raises(MalformedMessage, match="twice"):
        strict_json._object([(CountedName(name), 1) for name in names])
    assert CountedName.used < 10 * len(names)


@pytest.mark.parametrize(
    ("body", "fits"),
    [
        ("{" + ",".join(f'"{i}":1' for i in range(MAX_KEYS)) + "}", True),
        ("{" + ",".join(f'"{i}":1' for i in range(MAX_KEYS + 1)) + "}", False),
        ("[" + ",".join(["[]"] * (MAX_CONTAINERS - 1)) + "]", True),
        ("[" + ",".join(["[]"] * MAX_CONTAINERS) + "]", False),
        ("[" + ",".join(["{}"] * MAX_CONTAINERS) + "]", False),
    ],
    ids=["most keys", "too many keys", "most lists", "too many lists", "too many objects"],
)
def test_keys_and_containers_of_a_body_are_limited(body: str, fits: bool) -> None:
    if fits:
        assert parse(body.encode()) == json.loads(body)
    else:
        with pytest.raises(MessageTooLarge, match="at most"):
            parse(body.encode())


@pytest.mark.parametrize(("before", "after"), [("[", "]"), ('{"a":', "}"), ('[{"a":', "}]")])
def test_nesting_of_a_body_is_limited(before: str, after: str) -> None:
    count = MAX_DEPTH // (before.count("[") + before.count("{"))
    assert parse((before * count + "1" + after * count).encode())
    for depth in (count + 1, 900, 100_000):
        with pytest.raises(PPaaSError):
            parse((before * depth + "1" + after * depth).encode())


values = st.recursive(st.integers(), lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=2), inner))


BODIES = st.binary() | st.builds(
    lambda text, at, put: text[:at] + put + text[at:],
    values.map(lambda value: json.dumps(value).encode()),
    st.integers(0, 40),
    st.sampled_from([b"", b"\\", b'"', b"{", b"}", b"\xff", b"\0", b"\xed\xa0\x80", b"1e999", b"NaN", b"\\ud800"]),
)


@given(BODIES)
def test_any_bytes_are_read_or_refused(body: bytes) -> None:
    with contextlib.suppress(PPaaSError):
        parse(body)
