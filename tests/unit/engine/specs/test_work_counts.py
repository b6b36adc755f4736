"""Counts of what containers have done: classes of planning times, sums, and refusals."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.specs.work_counts import (
    CLASSES,
    ENDED,
    FAILED,
    MOST,
    PLAN_MICROS,
    PLAN_SECONDS,
    REUSED,
    STITCHED,
    add_counts,
    check_counts,
    plan_counts,
)
from ppaas.errors import InvalidParameter
from ppaas.messages.actionlib_msgs import Status
from ppaas.plans.history import computed_row, failed_row, found_row

KEY = "office", "v1", "dijkstra", 12


@given(st.floats(0.0, 1e4))
def test_a_computed_plan_is_in_the_first_class_that_has_room_for_it(seconds: float) -> None:
    counted = plan_counts(computed_row(KEY, seconds))
    micros = round(seconds * 1e6)
    [(number, name)] = [(number, name) for number, name in enumerate(CLASSES) if counted[name]]
    assert counted == +Counter({name: 1, PLAN_MICROS: micros})
    assert number == sum(limit < micros / 1e6 for limit in PLAN_SECONDS)


def test_other_outcomes_are_counted_by_name() -> None:
    assert plan_counts(failed_row(KEY)) == {FAILED: 1}
    assert plan_counts(found_row(KEY, "reused")) == {REUSED: 1}
    assert plan_counts(found_row(KEY, "stitched")) == {STITCHED: 1}


def test_each_end_of_a_goal_has_a_name_and_no_other_status_has_one() -> None:
    assert set(ENDED) == {status for status in Status if status.terminal}
    assert len(set(ENDED.values())) == len(ENDED)


@pytest.mark.parametrize(
    "counts", [{"goals": 1}, {FAILED: -1}, {FAILED: MOST + 1}, {FAILED: 1, "x" * 1000: 1}], ids=str
)
def test_counts_of_another_process_are_refused_whole(counts: dict[str, int]) -> None:
    total = Counter({FAILED: 3})
    with pytest.raises(InvalidParameter) as refused:
        add_counts(total, counts)
    assert total == {FAILED: 3} and len(str(refused.value)) < 200


def test_a_total_stays_at_its_limit_so_that_its_machine_is_not_refused() -> None:
    total = Counter[str]()
    for _ in range(3):
        add_counts(total, {FAILED: MOST})
    check_counts(total)
    assert total == {FAILED: MOST}
