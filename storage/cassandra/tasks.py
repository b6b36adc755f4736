"""Tasks in Cassandra: all users' tasks on a map are a partition."""

from ppaas.errors import NotFound
from ppaas.tasks.records import check_task
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.sorted_rows import SortedRows, generation_of, remove_marked
from storage.encoding import decode, decode_readable, encode
from storage.names import Group, check_group, check_name, check_task_key
from storage.records import MapTask

_GROUP = "map = ? AND user = ? AND generation = ?"
_ROWS = SortedRows("tasks", _GROUP, "id", "user DESC, generation DESC, id DESC", "record")
_PUT = f"UPDATE tasks SET record = ? WHERE {_GROUP} AND id = ? IF record = ?"

Key = tuple[str, str, int, str]
"""Map, user, the user's generation (``storage.cassandra.connection.cluster``), task."""


class CassandraTasks:
    """A ``TaskStore`` in Cassandra.

    Tasks end and are removed all the time: a removal first empties the record, and then deletes the row
    (``storage.cassandra.sorted_rows``).
    """

    _session: CassandraSession

    def put_task(self, record: MapTask, *, instead_of: MapTask | None = None) -> None:
        """Store a task; ``Conflict`` if the stored one is not ``instead_of``."""
        check_task(record.task)
        check_task_key(*record.key)
        key, data = (*self._task_group(record.user, record.map), record.task.id), encode(record)
        while True:
            before = self._task_record(key)
            if instead_of is not None and (not before or decode(before, MapTask, _place(key)) != instead_of):
                raise record.changed_meanwhile()
            if self._session.write_if(_PUT, data, *key, before):
                return

    def task(self, user: str, map_id: str, task_id: str) -> MapTask:
        """Return a task; ``NotFound`` if it does not exist."""
        check_task_key(user, map_id, task_id)
        key = *self._task_group(user, map_id), task_id
        data = self._task_record(key)
        if not data:
            raise NotFound("task", task_id)
        return decode(data, MapTask, _place(key))

    def tasks(self, user: str, map_id: str, *, after: str = "", limit: int | None = None) -> list[MapTask]:
        """Return the tasks of a user on a map, sorted by id."""
        query, group = f"SELECT id, record FROM tasks WHERE {_GROUP} AND id > ?", self._task_group(user, map_id)
        rows = (row for row in self._session.rows(query, *group, after) if row.record)
        return decode_readable(((row.record, _place((*group, row.id))) for row in rows), MapTask, limit)

    def task_groups(self) -> list[Group]:
        """Return the users and maps that have tasks, sorted."""
        found: set[Group] = set()
        for map_id in self._session.partitions("tasks", "map"):
            query = "SELECT user, generation FROM tasks WHERE map = ? GROUP BY user, generation"
            users = [(row.user, row.generation) for row in self._session.rows(query, map_id)]
            current = [one for one in users if one[1] == generation_of(self._session, one[0])]
            found |= {(user, map_id) for user, number in current if self._has_tasks((map_id, user, number))}
        return sorted(found)

    def remove_task(self, user: str, map_id: str, task_id: str) -> None:
        """Remove a task, if it exists."""
        check_task_key(user, map_id, task_id)
        group = self._task_group(user, map_id)
        while before := self._task_record((*group, task_id)):
            if self._session.write_if(_PUT, b"", *group, task_id, before):
                remove_marked(self._session, _ROWS, group, task_id)
                break

    def remove_tasks(self, map_id: str) -> None:
        """Remove the tasks of all users on a map, if there are any."""
        self._session.write("DELETE FROM tasks WHERE map = ?", check_name("map", map_id))

    # -- internals -----------------------------------------------------------------------------------------------------

    def _sweep_tasks(self, user: str, generation: int) -> None:
        for map_id in self._session.partitions("tasks", "map"):
            if self._session.row(f"SELECT id FROM tasks WHERE {_GROUP} LIMIT 1", map_id, user, generation) is not None:
                self._session.write(f"DELETE FROM tasks WHERE {_GROUP}", map_id, user, generation)

    def _has_tasks(self, group: tuple[str, str, int]) -> bool:
        return any(row.record for row in self._session.rows(f"SELECT record FROM tasks WHERE {_GROUP}", *group))

    def _task_group(self, user: str, map_id: str) -> tuple[str, str, int]:
        check_group(user, map_id)
        return map_id, user, generation_of(self._session, user)

    def _task_record(self, key: Key) -> bytes | None:
        row = self._session.row(f"SELECT record FROM tasks WHERE {_GROUP} AND id = ?", *key)
        return None if row is None else row.record


def _place(key: Key) -> str:
    map_id, user, _, task_id = key
    return f"tasks/{user}/{map_id}/{task_id}"
