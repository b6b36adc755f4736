"""JSON as Python's parser takes it, within bounds of size and time."""

import json
import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.messages.base.spelling import (
    MAX_OBJECTS,
    MAX_TOLERATED,
    MAX_VALUES,
    read_json,
    split_json,
    to_standard_json,
)

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
