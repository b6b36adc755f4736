"""Times of recent writes are remembered for a bounded number of keys."""

from storage.cassandra.plans.key_caches import BoundedCounts, LastWritten


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


def test_each_key_is_counted_up_to_the_limit() -> None:
    counted = BoundedCounts[str](2, 10)
    assert [counted.increase(key) for key in "aabab"] == [True, True, True, False, True]
    assert counted.is_full("a") and counted.is_full("b") and not counted.is_full("c")


def test_a_forgotten_key_is_counted_from_zero() -> None:
    counted = BoundedCounts[str](1, 10)
    assert counted.increase("a") and counted.increase("b")
    counted.forget("a")
    counted.forget("unknown")
    assert [counted.increase("a"), counted.increase("b")] == [True, False]
    counted.clear()
    assert counted.increase("b")


def test_the_least_recently_counted_key_is_forgotten_first() -> None:
    counted = BoundedCounts[int](2, 3)
    assert all(counted.increase(key) for key in (0, 1, 2, 0, 3, 3, 2))
    assert [counted.is_full(key) for key in range(4)] == [True, False, True, True]
