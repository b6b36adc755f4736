"""Dictionaries with a limited number of entries, packed data of a limited size, and numbers of command lines."""

import zlib

import pytest

from ppaas.bounded import BoundedDict, above_zero, inflated, whole
from ppaas.errors import InvalidParameter


def test_the_entry_that_was_assigned_first_is_dropped() -> None:
    entries: BoundedDict[str, int] = BoundedDict(2)
    for number, key in enumerate("abc"):
        entries[key] = number
    assert entries == {"b": 1, "c": 2}


def test_an_entry_that_is_assigned_again_is_the_newest() -> None:
    entries: BoundedDict[str, int] = BoundedDict(2)
    for number, key in enumerate("abac"):
        entries[key] = number
    assert list(entries.items()) == [("a", 2), ("c", 3)]


def test_an_entry_that_is_moved_to_the_end_is_kept() -> None:
    entries: BoundedDict[str, int] = BoundedDict(2)
    entries["a"], entries["b"] = 0, 1
    entries.move_to_end("a")
    entries["c"] = 2
    assert list(entries) == ["a", "c"]


def test_defaults_and_updates_are_limited_too() -> None:
    entries: BoundedDict[int, None] = BoundedDict(2)
    entries.update(dict.fromkeys(range(5)))
    assert list(entries) == [3, 4]
    assert entries.setdefault(5) is None
    assert list(entries) == [4, 5]


def test_a_removed_entry_leaves_space() -> None:
    entries: BoundedDict[str, int] = BoundedDict(2)
    entries["a"], entries["b"] = 0, 1
    del entries["a"]
    entries["c"] = 2
    assert list(entries) == ["b", "c"]


def test_integers_within_bounds_are_parsed() -> None:
    assert [whole()("1"), whole(0, 9)("0"), whole(most=9)("9"), whole(100)("1000000")] == [1, 0, 9, 1_000_000]


@pytest.mark.parametrize("text", ["0", "10", "-3", "1.5", "", "two", "1e1", "٣x"])
def test_other_text_than_an_integer_within_bounds_is_refused(text: str) -> None:
    with pytest.raises(InvalidParameter, match=r"whole number from 1 to 9, not"):
        whole(most=9)(text)
    with pytest.raises(InvalidParameter, match=r"whole number of at least 100, not"):
        whole(100)(text)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "61", "soon"])
def test_number_must_be_positive_and_within_its_bound(text: str) -> None:
    assert above_zero(60)("0.5") == 0.5
    with pytest.raises(InvalidParameter, match="above 0 and up to 60, not"):
        above_zero(60)(text)


@pytest.mark.parametrize("behind", [b"", b"\n", b"\0\0"])
def test_packed_data_is_inflated_up_to_its_limit(behind: bytes) -> None:
    packed = zlib.compress(b"map" * 100) + behind
    assert inflated(packed, 300) == inflated(memoryview(packed), 1000) == b"map" * 100
    with pytest.raises(OverflowError, match="more than 299 bytes"):
        inflated(packed, 299)


@pytest.mark.parametrize(
    ("packed", "reason"),
    [
        (b"map", "header"), (zlib.compress(b"map")[:-1], "end is missing"), (b"", "end is missing"),
        (zlib.compress(b"map") + zlib.compress(b"map"), "other data"), (zlib.compress(b"map")[:-1] + b"x", "check"),
    ],
)  # fmt: skip
def test_damaged_packed_data_is_an_error(packed: bytes, reason: str) -> None:
    with pytest.raises(zlib.error, match=reason):
        inflated(packed, 100)
