"""Tasks in Cassandra: those of all users on a map are a partition."""

from ppaas.errors import NotFound
from ppaas.tasks.records import check_task
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.generations import generation_of
from storage.encoding import decode, decode_readable, encode
from storage.names import Group, check_group, check_name, check_task_key
from storage.records import MapTask

_GROUP = "map = ? AND user = ? AND generation = ?"


class CassandraTasks:
    """A ``TaskStore`` in Cassandra."""

    _session: CassandraSession

    def put_task(self, record: MapTask, *, instead_of: MapTask | None = None) -> None:
        """Store a task; ``Conflict`` if the stored one is not ``instead_of``."""
        check_task(record.task)
        check_task_key(*record.key)
        key, data = (*self._task_group(record.user, record.map), record.task.id), encode(record)
        while True:
            before = self._task_record(key)
            if instead_of is not None and (before is None or decode(before, MapTask) != instead_of):
                raise record.changed_meanwhile()
            write = f"UPDATE tasks SET record = ? WHERE {_GROUP} AND id = ? IF record = ?"
            if self._session.write_if(write, data, *key, before):
                return

    def task(self, user: str, map_id: str, task_id: str) -> MapTask:
        """Return a task; ``NotFound`` if it does not exist."""
        check_task_key(user, map_id, task_id)
        data = self._task_record((*self._task_group(user, map_id), task_id))
        if data is None:
            raise NotFound("task", task_id)
        return decode(data, MapTask)

    def tasks(self, user: str, map_id: str, *, after: str = "", limit: int | None = None) -> list[MapTask]:
        """Return the tasks of a user on a map, sorted by id."""
        query = f"SELECT record FROM tasks WHERE {_GROUP} AND id > ?"
        rows = self._session.rows(query, *self._task_group(user, map_id), after)
        return decode_readable((row.record for row in rows if row.record), MapTask, limit)

    def task_groups(self) -> list[Group]:
        """Return the users and maps that have tasks, sorted."""
        found: set[Group] = set()
        for map_id in self._session.partitions("tasks", "map"):
            rows = self._session.rows("SELECT user, generation FROM tasks WHERE map = ?", map_id)
            users = {(row.user, row.generation) for row in rows}
            found |= {(user, map_id) for user, number in users if number == generation_of(self._session, user)}
        return sorted(found)

    def remove_task(self, user: str, map_id: str, task_id: str) -> None:
        """Remove a task, if it exists."""
        check_task_key(user, map_id, task_id)
        key = *self._task_group(user, map_id), task_id
        self._session.write(f"DELETE FROM tasks WHERE {_GROUP} AND id = ?", *key)

    def remove_tasks(self, map_id: str) -> None:
        """Remove the tasks of all users on a map, if there are any."""
        self._session.write("DELETE FROM tasks WHERE map = ?", check_name("map", map_id))

    # -- internals -----------------------------------------------------------------------------------------------------

    def _sweep_tasks(self, user: str, generation: int) -> None:
        """Remove the rows of an old generation of a user."""
        for map_id in self._session.partitions("tasks", "map"):
            self._session.write(f"DELETE FROM tasks WHERE {_GROUP}", map_id, user, generation)

    def _task_group(self, user: str, map_id: str) -> tuple[str, str, int]:
        check_group(user, map_id)
        return map_id, user, generation_of(self._session, user)

    def _task_record(self, key: tuple[str, str, int, str]) -> bytes | None:
        row = self._session.row(f"SELECT record FROM tasks WHERE {_GROUP} AND id = ?", *key)
        return None if row is None else row.record
