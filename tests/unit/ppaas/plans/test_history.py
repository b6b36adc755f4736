"""The evaluation sums up requests, and reports nothing without data."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.plans.history import (
    MOST_BUCKETS,
    as_json,
    bucket_of,
    bucket_range,
    compared_row,
    computed_row,
    evaluate,
    failed_row,
    found_row,
)

FAR, NEAR = ("house", "v1", "astar", 14), ("house", "v1", "astar", 4)


def test_planner_is_evaluated_in_total_and_by_complexity() -> None:
    rows = [
        computed_row(FAR, 0.4), computed_row(FAR, 0.1), computed_row(NEAR, 0.01), failed_row(NEAR),
        found_row(FAR, "reused"), found_row(FAR, "stitched"), compared_row(FAR, 11.0, 10.0),
    ]  # fmt: skip
    (astar,) = evaluate(rows)
    performance = astar.performance
    assert (performance.queries, performance.computed, performance.reused, performance.stitched) == (6, 3, 1, 1)
    assert performance.success == pytest.approx(5 / 6)
    assert performance.reuse_rate == pytest.approx(2 / 5)
    assert performance.seconds == pytest.approx(0.17)
    assert performance.over_cheapest == pytest.approx(0.1)
    near, far = astar.complexities
    assert (near.cells, far.cells) == (bucket_range(4), bucket_range(14))
    assert far.performance.typical_seconds == pytest.approx(0.2, rel=1e-3)
    assert far.performance.spread == pytest.approx(2.0, rel=1e-2)
    assert near.performance.over_cheapest is None
    assert as_json(astar)["complexities"][1]["cells"] == [64.0 * 2.0**0.5, 128.0]


def test_planners_are_sorted_by_name_over_all_versions() -> None:
    rows = [failed_row(("house", version, planner, 1)) for version in ("v2", "v1") for planner in ("jps", "astar")]
    assert [(each.planner, each.performance.queries) for each in evaluate(rows)] == [("astar", 2), ("jps", 2)]
    assert evaluate([]) == []


def test_missing_data_is_reported_as_none() -> None:
    (astar,) = evaluate([failed_row(NEAR)])
    performance = astar.performance
    assert performance.success == 0.0
    unknown = (performance.reuse_rate, performance.seconds, performance.typical_seconds, performance.spread)
    assert unknown == (None, None, None, None)


@given(st.floats(min_value=0.0, max_value=1e9, allow_nan=False))
def test_a_complexity_lies_in_its_bucket(cells: float) -> None:
    bucket = bucket_of(cells)
    first, last = bucket_range(bucket)
    assert 0 <= bucket < MOST_BUCKETS
    assert first * (1 - 1e-9) <= cells <= last * (1 + 1e-9)
