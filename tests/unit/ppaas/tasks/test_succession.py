"""Which tasks may begin after others, and which task follows one that repeats."""

from typing import Any

import pytest

from ppaas.tasks.options import After, End, Repeat
from ppaas.tasks.records import Task, TaskState
from ppaas.tasks.succession import following, in_series, verdict


def task(**fields: Any) -> Task:
    return Task(id="t", kind="go_to", places=((1.0, 0.0, 0.0),), **fields)


@pytest.mark.parametrize(
    ("on", "ended", "expected"),
    [
        ("done", "done", "ready"),
        ("done", "failed", "never"),
        ("failed", "done", "never"),
        ("failed", "failed", "ready"),
        ("failed", "cancelled", "never"),
        ("ended", "cancelled", "ready"),
        ("done", None, "waits"),
    ],
)
def test_a_task_begins_after_another_has_ended_as_it_was_to_end(
    on: End, ended: TaskState | None, expected: str
) -> None:
    known: dict[str, TaskState] = {} if ended is None else {"a": ended}
    found, reason = verdict(task(after=(After(task="a", on=on),)), known, {"a"} - known.keys())
    assert found == expected
    assert ("'a'" in reason) == (expected != "ready")


def test_all_tasks_that_come_first_must_end() -> None:
    both = task(after=(After(task="a"), After(task="b", on="ended")))
    assert verdict(both, {"a": "done"}, {"b"})[0] == "waits"
    assert verdict(both, {"b": "failed"}, {"a"})[0] == "waits"
    assert verdict(both, {"a": "done", "b": "failed"}, set())[0] == "ready"
    assert verdict(both, {"a": "failed"}, {"b"})[0] == "never"


def test_a_task_that_was_removed_never_ends() -> None:
    found, reason = verdict(task(after=(After(task="a"),)), {}, set())
    assert (found, "not known" in reason) == ("never", True)


def test_the_next_run_is_the_same_whenever_it_is_made_and_its_deadline_moves_along() -> None:
    first = task(
        repeat=Repeat(every=60.0, count=3), created=100.0, deadline=130.0, labels={"a": "b"}, weight=2.0, priority=4
    )
    second = following(first, 110.0)
    assert second is not None
    assert (second.id, second.series, second.run, second.not_before, second.deadline) == ("t-2", "t", 2, 160.0, 190.0)
    assert (second.labels, second.weight, second.priority, second.state) == ({"a": "b"}, 2.0, 4, "queued")
    third = following(second, 170.0)
    assert third is not None
    assert (third.id, third.series, third.run, third.not_before) == ("t-3", "t", 3, 220.0)
    assert following(third, 230.0) is None
    assert following(task(), 1.0) is None


def test_no_run_starts_after_the_last_time() -> None:
    assert following(task(repeat=Repeat(every=60.0, until=159.0), created=100.0), 110.0) is None


def test_the_first_run_at_times_of_day_waits_for_the_first_of_them() -> None:
    day = 20_000 * 86400.0
    daily = task(repeat=Repeat(at=("08:00",)))
    assert in_series(daily, day).not_before == day + 8 * 3600.0
    assert in_series(daily, day + 8 * 3600.0).not_before == day + 8 * 3600.0
    assert in_series(daily, day + 8 * 3600.0 + 5.0).not_before == day + 32 * 3600.0
    later = task(repeat=Repeat(at=("08:00",)), not_before=day + 9 * 3600.0)
    assert in_series(later, day).not_before == day + 32 * 3600.0
    assert in_series(task(repeat=Repeat(every=60.0)), day).not_before is None
