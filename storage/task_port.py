"""Port of tasks that any robot of a user on a map may do, by the rules of ``storage.ports``."""

from typing import Protocol

from storage.task_records import Group, MapTask


class TaskStore(Protocol):
    """Tasks of users on maps, and what became of them."""

    def put_task(self, record: MapTask, *, instead_of: MapTask | None = None) -> None:
        """Store a task.

        Raises
        ------
        Conflict
            ``instead_of`` is given and differs from the stored record: another process changed it first.
        """
        ...

    def task(self, user: str, map_id: str, task_id: str) -> MapTask:
        """Return a task; ``NotFound`` if it does not exist."""
        ...

    def tasks(self, user: str, map_id: str, *, after: str = "", limit: int | None = None) -> list[MapTask]:
        """Return the tasks of a user on a map, sorted by id."""
        ...

    def task_groups(self) -> list[Group]:
        """Return the users and maps that have tasks, sorted; the maps may have been removed."""
        ...

    def remove_task(self, user: str, map_id: str, task_id: str) -> None:
        """Remove a task, if it exists."""
        ...

    def remove_tasks(self, map_id: str) -> None:
        """Remove the tasks of all users on a map, if there are any."""
        ...
