"""There is room for so many of each key, as far as is remembered."""

from storage.cassandra.plans.bounded_counts import BoundedCounts


def test_there_is_room_for_so_many_of_each() -> None:
    counted = BoundedCounts[str](2, 10)
    assert [counted.take(key) for key in "aabab"] == [True, True, True, False, True]
    assert counted.is_full("a") and counted.is_full("b") and not counted.is_full("c")


def test_what_is_forgotten_is_counted_from_nothing() -> None:
    counted = BoundedCounts[str](1, 10)
    assert counted.take("a") and counted.take("b")
    counted.forget("a")
    counted.forget("unknown")
    assert [counted.take("a"), counted.take("b")] == [True, False]
    counted.clear()
    assert counted.take("b")


def test_what_was_counted_first_is_forgotten_first() -> None:
    counted = BoundedCounts[int](2, 3)
    assert all(counted.take(key) for key in (0, 1, 2, 0, 3, 3, 2))
    assert [counted.is_full(key) for key in range(4)] == [True, False, True, True]
