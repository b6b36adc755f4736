"""What was written of late is known, until there is too much of it."""

from storage.cassandra.plans.last_written import LastWritten


def test_what_was_not_written_since_then_is_late() -> None:
    written = LastWritten[str](10)
    written.note({"a": 1.0, "b": 5.0})
    assert written.late(["a", "b", "c", "a"], 3.0) == ["a", "c"]
    written.note({"a": 4.0})
    assert written.late(["a", "b"], 3.0) == []


def test_what_was_noted_first_is_forgotten_first() -> None:
    written = LastWritten[int](3)
    written.note(dict.fromkeys(range(3), 1.0))
    written.note({0: 2.0, 3: 2.0})
    assert written.late(range(4), 0.0) == [1]
