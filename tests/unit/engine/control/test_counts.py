"""Counts of the master."""

from hypothesis import given
from hypothesis import strategies as st

from engine.control.counts import PLACEMENT_SECONDS, BucketCounts, ControlCounts
from engine.specs.work_counts import CLASSES, ENDED, FAILED, PLAN_MICROS, REUSED
from ppaas.messages.actionlib_msgs import Status


@given(st.lists(st.floats(0.0, 1e4)))
def test_each_value_is_in_the_first_class_that_has_room_for_it(values: list[float]) -> None:
    counted = BucketCounts(PLACEMENT_SECONDS)
    for value in values:
        counted.add(value)
    assert sum(counted.counts) == len(values) and counted.total == sum(values)
    for number, limit in enumerate(counted.limits):
        assert sum(counted.counts[: number + 1]) == sum(value <= limit for value in values)


def test_what_machines_report_is_counted_from_their_first_report_on() -> None:
    counts = ControlCounts()
    counts.machine_worked("m1", {FAILED: 7})  # it worked for the master before
    counts.machine_worked("m1", {FAILED: 9, CLASSES[2]: 3, PLAN_MICROS: 4_500})
    counts.machine_worked("m2", {})
    counts.machine_worked("m2", {CLASSES[0]: 1, PLAN_MICROS: 500, REUSED: 2})
    classes, total = counts.plans()
    assert (classes[0], classes[2], sum(classes), total) == (1, 3, 4, 0.005)
    assert counts.plan_origins() == {"computed": 4, "reused": 2, "stitched": 0, "failed": 2}


def test_the_next_agent_of_a_machine_begins_at_zero() -> None:
    counts = ControlCounts()
    for failed in (0, 5):
        counts.machine_worked("m1", {FAILED: failed})
    counts.machine_left("m1")
    for failed in (2, 3):
        counts.machine_worked("m1", {FAILED: failed})
    assert counts.plan_origins()["failed"] == 6


def test_a_machine_that_counts_backwards_takes_nothing_away() -> None:
    counts = ControlCounts()
    for failed in (0, 5, 1):
        counts.machine_worked("m1", {FAILED: failed})
    assert counts.plan_origins()["failed"] == 5


def test_goals_of_clients_are_counted_with_the_goals_of_the_master() -> None:
    counts = ControlCounts()
    counts.goals["succeeded"] += 1
    counts.machine_worked("m1", {})
    counts.machine_worked("m1", {ENDED[Status.SUCCEEDED]: 2, ENDED[Status.PREEMPTED]: 1, ENDED[Status.RECALLED]: 1})
    assert +counts.goals == {"succeeded": 3, "canceled": 2}
