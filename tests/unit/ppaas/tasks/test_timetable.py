"""Time tables of tasks: when robots set out, begin and finish, who waits and who is late."""

from typing import Any

from ppaas.tasks.records import Task
from ppaas.tasks.timetable import time_table


def task(name: str, **fields: Any) -> Task:
    return Task(id=name, kind="go_to", places=((1.0, 0.0, 0.0),), created=100.0, **fields)


def test_rows_are_in_the_order_in_which_robots_set_out() -> None:
    done: dict[str, Any] = {"state": "done", "begun": 130.0}
    rows = time_table(
        [
            task("never", deadline=150.0, state="failed", reason="no robot", ended=150.5),
            task("second", robot="r", assigned=120.0, ended=140.0, not_before=110.0, deadline=139.0, **done),
            task("first", robot="r", assigned=105.0, ended=130.0, deadline=130.0, **done),
        ],
        100.0,
    )
    assert [row.task for row in rows] == ["first", "second", "never"]
    first, second, never = rows
    assert (first.set_out, first.begin, first.finish, first.waits, first.late) == (5.0, 30.0, 30.0, 5.0, False)
    assert (second.waits, second.late) == (10.0, True)
    assert (never.set_out, never.waits, never.late, never.reason) == (None, None, True, "no robot")


def test_a_task_without_a_deadline_is_never_late() -> None:
    assert not time_table([task("t", state="failed", ended=1e6)], 100.0)[0].late


def test_floors_are_listed_in_the_order_in_which_a_task_leads_over_them() -> None:
    over = Task(id="t", kind="patrol", places=((1.0, 0.0, 0.0),) * 4, floors=("L1", "L1", "L2", "L1"))
    assert [row.floors for row in time_table([over, task("u")], 0.0)] == ["L1 → L2 → L1", ""]
