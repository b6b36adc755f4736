"""Time tables of tasks that were rehearsed, or that robots have done."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from ppaas.tasks.records import Task, TaskState


@dataclass(frozen=True, slots=True)
class TimeTableRow:
    """A task of a time table. Times are seconds after its start; None if that has not happened.

    Parameters
    ----------
    task : str
        Id of the task.
    robot : str
        Robot that did it; empty if none did.
    set_out, begin, finish : float, optional
        Times at which the robot set out, was at the first place, and ended the task.
    waits : float, optional
        Time from the moment from which it could begin until its robot set out; None if none did.
    state : TaskState
    late : bool
        Whether it has a deadline and did not end before.
    reason : str
        Why it ended, or waits again; empty if it was done.
    floors : str
        Floors that it leads over, in order; empty if it names none.
    """

    task: str
    robot: str
    set_out: float | None
    begin: float | None
    finish: float | None
    waits: float | None
    state: TaskState
    late: bool
    reason: str
    floors: str = ""


def time_table(tasks: Iterable[Task], start: float) -> list[TimeTableRow]:
    """Return the rows of tasks, in the order in which robots set out; those that no robot did are last.

    Parameters
    ----------
    tasks : iterable of Task
    start : float
        Time from which the table counts [s since the epoch].
    """
    rows = [_row(task, start) for task in tasks]
    return sorted(rows, key=lambda row: (row.set_out is None, row.set_out or 0.0, row.robot, row.task))


def _row(task: Task, start: float) -> TimeTableRow:
    def since(time: float | None) -> float | None:
        return None if time is None else time - start

    late = task.deadline is not None and (task.state != "done" or (task.ended or 0.0) > task.deadline)
    waits = None if task.assigned is None else max(0.0, task.assigned - task.may_start)
    times = since(task.assigned), since(task.begun), since(task.ended)
    floors = " → ".join(floor for floor, _ in groupby(task.floors))
    return TimeTableRow(task.id, task.robot, *times, waits, task.state, late, task.reason, floors)
