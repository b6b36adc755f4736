"""Records of the tasks of a user on a map."""

import msgspec

from ppaas.errors import Conflict
from ppaas.tasks.records import Task, check_task
from storage.names import check_name

Group = tuple[str, str]
"""User and map."""


class MapTask(msgspec.Struct, frozen=True):
    """A task of a user on a map.

    Parameters
    ----------
    user, map : str
    task : Task
    """

    user: str
    map: str
    task: Task

    @property
    def key(self) -> tuple[str, str, str]:
        """User, map and id."""
        return self.user, self.map, self.task.id


def check_group(user: str, map_id: str) -> Group:
    """Return a user and a map; ``InvalidInput`` if a name is not valid."""
    return check_name("user", user), check_name("map", map_id)


def check_task_key(user: str, map_id: str, task_id: str) -> tuple[str, str, str]:
    """Return the key of a task; ``InvalidInput`` if a name is not valid."""
    return *check_group(user, map_id), check_name("task", task_id)


def check_record(record: MapTask) -> tuple[str, str, str]:
    """Return the key of a task; ``InvalidInput`` if a name is not valid, or the task makes no sense."""
    check_task(record.task)
    return check_task_key(*record.key)


def changed_meanwhile(task_id: str) -> Conflict:
    """Return the error of a task that another process changed first."""
    return Conflict(f"task {task_id!r} has been changed meanwhile: read it again and retry")
