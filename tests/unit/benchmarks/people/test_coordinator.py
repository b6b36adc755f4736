"""Part ``coordinator`` of the people bench: its figures, with the bar on the largest group alone."""

import pytest

from benchmarks.people import coordinator
from benchmarks.people.options import PeopleOptions


def test_the_largest_group_has_the_bar_and_the_baseline(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coordinator, "GROUPS", ((1, 2), (2, 4)))
    monkeypatch.setattr(coordinator, "QUICK", 3)
    monkeypatch.setattr(coordinator, "FIRST", 1)
    result = coordinator.measure(PeopleOptions(quick=True))
    assert [figure.limit for figure in result.figures] == [None, coordinator.LONGEST, None]
    assert [figure.yardstick for figure in result.figures] == [False, False, True]
    assert [row["robots"] for row in result.rows] == ["1", "2"]
    assert all(each["cycle_p99_ms"] > 0.0 for each in result.results)
