"""Counts of the master."""

from hypothesis import given
from hypothesis import strategies as st

from engine.control.counts import PLACEMENT_SECONDS, BucketCounts


@given(st.lists(st.floats(0.0, 1e4)))
def test_each_value_is_in_the_first_class_that_has_room_for_it(values: list[float]) -> None:
    counted = BucketCounts(PLACEMENT_SECONDS)
    for value in values:
        counted.add(value)
    assert sum(counted.counts) == len(values) and counted.total == sum(values)
    for number, limit in enumerate(counted.limits):
        assert sum(counted.counts[: number + 1]) == sum(value <= limit for value in values)
