"""Ranges of the numbers of log entries."""

from hypothesis import given
from hypothesis import strategies as st

from storage.cassandra.robots import entry_runs, joined

NUMBERS = st.sets(st.integers(0, 40))


def test_successive_numbers_are_one_run() -> None:
    assert entry_runs([5, 3, 4, 9, 4]) == [(3, 5), (9, 9)]
    assert entry_runs([]) == []


@given(NUMBERS, st.data())
def test_gaps_contain_the_removed_entries_and_no_others_and_join_where_nothing_is_between(
    stored: set[int], data: st.DataObject
) -> None:
    removed = data.draw(st.sets(st.sampled_from(sorted(stored)))) if stored else set[int]()
    runs = entry_runs(removed)
    beside = [
        (
            max((one for one in stored if one < first), default=-1),
            min((one for one in stored if one > last), default=last + 1),
        )
        for first, last in runs
    ]
    gaps = joined(runs, beside)
    assert {one for one in stored for low, high in gaps if low < one < high} == removed
    assert len(gaps) <= len(stored - removed) + 1
