"""Tasks in memory."""

import threading
from collections.abc import Callable

from ppaas.errors import NotFound
from ppaas.tasks.records import check_task
from storage.encoding import decode, encode
from storage.names import Group, check_group, check_name, check_task_key
from storage.records import MapTask


class MemoryTasks:
    """A ``TaskStore`` of a dictionary. Tasks are stored as bytes, because a caller may change their labels."""

    def __init__(self) -> None:
        self._tasks_lock = threading.Lock()
        self._tasks: dict[tuple[str, str, str], bytes] = {}

    def put_task(self, record: MapTask, *, instead_of: MapTask | None = None) -> None:
        """Store a task; ``Conflict`` if the stored one is not ``instead_of``."""
        check_task(record.task)
        key, data = check_task_key(*record.key), encode(record)
        with self._tasks_lock:
            before = self._tasks.get(key)
            if instead_of is not None and (before is None or decode(before, MapTask) != instead_of):
                raise record.changed_meanwhile()
            self._tasks[key] = data

    def task(self, user: str, map_id: str, task_id: str) -> MapTask:
        """Return a task; ``NotFound`` if it does not exist."""
        key = check_task_key(user, map_id, task_id)
        with self._tasks_lock:
            if key not in self._tasks:
                raise NotFound("task", task_id)
            return decode(self._tasks[key], MapTask)

    def tasks(self, user: str, map_id: str, *, after: str = "", limit: int | None = None) -> list[MapTask]:
        """Return the tasks of a user on a map, sorted by id."""
        group = check_group(user, map_id)
        with self._tasks_lock:
            keys = sorted(key for key in self._tasks if key[:2] == group and key[2] > after)[:limit]
            return [decode(self._tasks[key], MapTask) for key in keys]

    def task_groups(self) -> list[Group]:
        """Return the users and maps that have tasks, sorted."""
        with self._tasks_lock:
            return sorted({key[:2] for key in self._tasks})

    def remove_task(self, user: str, map_id: str, task_id: str) -> None:
        """Remove a task, if it exists."""
        key = check_task_key(user, map_id, task_id)
        with self._tasks_lock:
            self._tasks.pop(key, None)

    def remove_tasks(self, map_id: str) -> None:
        """Remove the tasks of all users on a map, if there are any."""
        check_name("map", map_id)
        self._forget_tasks(lambda group: group[1] == map_id)

    def _forget_tasks(self, forgotten: Callable[[Group], bool]) -> None:
        """Remove the tasks of the users and maps for which a function returns true."""
        with self._tasks_lock:
            self._tasks = {key: data for key, data in self._tasks.items() if not forgotten(key[:2])}
