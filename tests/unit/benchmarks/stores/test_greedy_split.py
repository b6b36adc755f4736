"""Greedy deduplication counts the waypoints that it would store."""

from benchmarks.stores.baselines import GreedySplit


def test_a_stored_plan_adds_no_waypoints() -> None:
    split = GreedySplit(4)
    for _ in range(3):
        split.add(range(100))
    assert (split.waypoints, split.kept) == (300, 100)
    assert split.ids_per_plan() == 1.0


def test_a_shared_segment_splits_the_plan_that_contained_it() -> None:
    split = GreedySplit(4)
    split.add(range(100))
    split.add([*range(500, 510), *range(20, 60), *range(600, 605)])
    assert split.kept == 115
    assert split.ids_per_plan() == (3 + 3) / 2


def test_a_segment_shorter_than_the_granularity_is_stored_again() -> None:
    split = GreedySplit(8)
    split.add(range(100))
    split.add([*range(500, 510), *range(20, 27), *range(600, 605)])
    assert split.kept == 122
