"""Counts of keys have a limit, and a bounded number of keys is remembered."""

from storage.cassandra.plans.bounded_counts import BoundedCounts


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
