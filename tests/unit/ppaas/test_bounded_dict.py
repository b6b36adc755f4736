"""Dictionaries with a limited number of entries."""

from ppaas.bounded import BoundedDict


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
