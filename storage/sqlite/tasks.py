"""Tasks in an SQLite file."""

from ppaas.errors import NotFound
from ppaas.tasks.records import check_task
from storage.encoding import decode, decode_readable, encode
from storage.names import Group, check_group, check_name, check_task_key
from storage.records import MapTask
from storage.sqlite.connections import SqliteConnections

_PLACE = "'tasks/' || user || '/' || map || '/' || id"
_RECORD = f"SELECT record, {_PLACE} FROM tasks WHERE user = ? AND map = ? AND id = ?"


class SqliteTasks:
    """A ``TaskStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._task_connections = connections

    def put_task(self, record: MapTask, *, instead_of: MapTask | None = None) -> None:
        """Store a task; ``Conflict`` if the stored one is not ``instead_of``."""
        check_task(record.task)
        key, data = check_task_key(*record.key), encode(record)
        with self._task_connections.writing() as connection:
            row = connection.execute(_RECORD, key).fetchone()
            if instead_of is not None and (row is None or decode(row[0], MapTask, row[1]) != instead_of):
                raise record.changed_meanwhile()
            connection.execute("INSERT OR REPLACE INTO tasks VALUES (?, ?, ?, ?)", (*key, data))

    def task(self, user: str, map_id: str, task_id: str) -> MapTask:
        """Return a task; ``NotFound`` if it does not exist."""
        key = check_task_key(user, map_id, task_id)
        with self._task_connections.reading() as connection:
            row = connection.execute(_RECORD, key).fetchone()
        if row is None:
            raise NotFound("task", task_id)
        return decode(row[0], MapTask, row[1])

    def tasks(self, user: str, map_id: str, *, after: str = "", limit: int | None = None) -> list[MapTask]:
        """Return the tasks of a user on a map, sorted by id."""
        query = f"SELECT record, {_PLACE} FROM tasks WHERE user = ? AND map = ? AND id > ? ORDER BY id"
        with self._task_connections.reading() as connection:
            rows = connection.execute(query, (*check_group(user, map_id), after))
            return decode_readable(rows, MapTask, limit)

    def task_groups(self) -> list[Group]:
        """Return the users and maps that have tasks, sorted."""
        query = "SELECT DISTINCT user, map FROM tasks ORDER BY user, map"
        with self._task_connections.reading() as connection:
            return [(user, map_id) for user, map_id in connection.execute(query)]

    def remove_task(self, user: str, map_id: str, task_id: str) -> None:
        """Remove a task, if it exists."""
        key = check_task_key(user, map_id, task_id)
        with self._task_connections.writing() as connection:
            connection.execute("DELETE FROM tasks WHERE user = ? AND map = ? AND id = ?", key)

    def remove_tasks(self, map_id: str) -> None:
        """Remove the tasks of all users on a map, if there are any."""
        check_name("map", map_id)
        with self._task_connections.writing() as connection:
            connection.execute("DELETE FROM tasks WHERE map = ?", (map_id,))
