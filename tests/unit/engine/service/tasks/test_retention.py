"""Ended tasks are kept for a while, and not without end."""

from engine.service.tasks.group import KEPT_FOR, MOST_ENDED, obsolete
from ppaas.tasks.records import Task


def ended(name: str, at: float) -> Task:
    return Task(id=name, kind="go_to", places=((0.0, 0.0, 0.0),), state="done", ended=at)


def test_tasks_are_removed_some_days_after_their_end() -> None:
    waiting = Task(id="w", kind="go_to", places=((0.0, 0.0, 0.0),))
    assert obsolete([ended("old", 0.0), ended("new", 5.0), waiting], KEPT_FOR + 3.0) == ["old"]


def test_of_many_tasks_the_oldest_are_removed() -> None:
    tasks = [ended(f"t{number}", float(number)) for number in range(MOST_ENDED + 2)]
    assert sorted(obsolete(tasks, 2000.0)) == ["t0", "t1"]
