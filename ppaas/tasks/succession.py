"""Succession of tasks: those that begin after others, and the next run of one that repeats."""

from collections.abc import Container, Mapping
from typing import Literal

from msgspec.structs import replace

from ppaas.tasks.options import next_start
from ppaas.tasks.records import Task, TaskState


def verdict(
    task: Task, ended: Mapping[str, TaskState], open_tasks: Container[str]
) -> tuple[Literal["ready", "waits", "never"], str]:
    """Return whether the tasks that must come first allow a task to begin, and the reason if they do not.

    Parameters
    ----------
    task : Task
    ended : mapping of str to TaskState
        How other tasks have ended, by id.
    open_tasks : container of str
        Ids of tasks that have not ended.
    """
    waits = ""
    for before in task.after:
        state = ended.get(before.task)
        if state is None and before.task in open_tasks:
            waits = waits or f"it begins after task {before.task!r}"
        elif state is None:
            return "never", f"task {before.task!r} was to end first, and is not known any more"
        elif before.on not in {"ended", state}:
            return "never", f"task {before.task!r} is {state}: this task was to begin after it is {before.on}"
    return ("waits", waits) if waits else ("ready", "")


def following(task: Task, now: float) -> Task | None:
    """Return the next run of a task that has ended; None if there is none.

    Its id follows from the ended one, so that it is the same whenever it is made.
    """
    repeat = task.repeat
    if repeat is None or (repeat.count is not None and task.run >= repeat.count):
        return None
    before = task.created if task.not_before is None else task.not_before
    start = next_start(repeat, before, now)
    if repeat.until is not None and start > repeat.until:
        return None
    series, run = task.series or task.id, task.run + 1
    return Task(
        id=f"{series}-{run}",
        series=series,
        run=run,
        not_before=start,
        created=now,
        deadline=None if task.deadline is None else task.deadline + start - before,
        **{name: getattr(task, name) for name in _KEPT},
    )


_KEPT = (
    "kind", "places", "floors", "home", "rounds", "priority", "labels", "holds", "named_robot", "weight", "preempts",
    "repeat",
)  # fmt: skip


def in_series(task: Task, created: float) -> Task:
    """Return a new task as the first run of its series: one at times of day starts at the first of these."""
    repeat = task.repeat
    if repeat is None or not repeat.at:
        return task
    first = created if task.not_before is None else max(created, task.not_before)
    return replace(task, not_before=next_start(repeat, first - 1.0, first - 1.0))
