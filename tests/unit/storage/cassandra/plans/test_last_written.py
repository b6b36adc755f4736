"""Times of recent writes are remembered for a bounded number of keys."""

from storage.cassandra.plans.last_written import LastWritten


def test_keys_that_were_not_written_since_a_time_are_returned() -> None:
    written = LastWritten[str](10)
    written.record({"a": 1.0, "b": 5.0})
    assert written.older(["a", "b", "c", "a"], 3.0) == ["a", "c"]
    written.record({"a": 4.0})
    assert written.older(["a", "b"], 3.0) == []


def test_the_least_recently_written_key_is_forgotten_first() -> None:
    written = LastWritten[int](3)
    written.record(dict.fromkeys(range(3), 1.0))
    written.record({0: 2.0, 3: 2.0})
    assert written.older(range(4), 0.0) == [1]
