"""Everything but maps in one SQLite file: the embedded default, nothing to install.

A row has the keys in columns and the record as bytes (``storage.encoding``), so a record may get a new field without a
new schema.
"""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection
from typing import Any

import msgspec

from ppaas.errors import Conflict, NotFound
from ppaas.plans.encoding.granularity import GRANULARITY
from ppaas.plans.history import LinkHistory
from storage.buildings.records import BuildingRecord
from storage.encoding import R, decode, decode_readable, encode
from storage.names import check_name, check_robot_map
from storage.people import MapPeople
from storage.records import CloneCheckpoint, CloneLogChange, Lease, MapTask, RobotRecord, Token, User, check_lease
from storage.robot_shares import RobotShares
from storage.sharing_records import check_grantee
from storage.sqlite.buildings import SqliteBuildings
from storage.sqlite.connections import SqliteConnections
from storage.sqlite.history import SqliteHistory
from storage.sqlite.identities import SqliteIdentities
from storage.sqlite.people import SqlitePeople
from storage.sqlite.plans import SqlitePlans
from storage.sqlite.tasks import SqliteTasks
from storage.sqlite.webhooks import SqliteWebhooks
from storage.webhooks.records import Webhook, WebhookDelivery

# Leases, for candidates on one host.

_FIRST = "INSERT INTO leases (name, holder, epoch, beat) VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING"

_CHANGE = """UPDATE leases SET holder = ?, epoch = ?, beat = ?
             WHERE name = ? AND holder = ? AND epoch = ? AND beat = ?"""


class SqliteLeases:
    """A ``LeaseStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._lease_connections = connections

    def lease(self, name: str) -> Lease:
        """Return a lease; one of epoch 0 without a holder if it was never taken."""
        query = "SELECT holder, epoch, beat FROM leases WHERE name = ?"
        with self._lease_connections.reading() as connection:
            row = connection.execute(query, (check_name("lease", name),)).fetchone()
        return Lease(name) if row is None else Lease(name, *row)

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        """Store a lease if the stored one is ``instead_of``; return whether it was.

        A beat is not synced: all candidates are on this host, and end with it when its power fails.
        """
        check_lease(lease, instead_of)
        new, old = _values(lease), _values(instead_of)
        with self._lease_connections.writing(synced=lease.epoch != instead_of.epoch) as connection:
            first = instead_of == Lease(lease.name) and connection.execute(_FIRST, (lease.name, *new)).rowcount
            return bool(first or connection.execute(_CHANGE, (*new, lease.name, *old)).rowcount)


def _values(lease: Lease) -> tuple[str, int, int]:
    return lease.holder, lease.epoch, lease.beat


_OF_USER = (
    *("robots", "robot_shares", "urdfs", "clones", "clone_logs"),
    *("people", "people_counts", "tasks", "buildings", "webhooks", "webhook_deliveries"),
)
"""Tables of what belongs to a user, beside the tokens."""

_RECORDS: dict[str, tuple[type[msgspec.Struct], str]] = {
    "users": (User, "id"),
    "tokens": (Token, "hash"),
    "robots": (RobotRecord, "user || '/' || id"),
    "clones": (CloneCheckpoint, "user || '/' || robot"),
    "people": (MapPeople, "map || '/' || user"),
    "tasks": (MapTask, "user || '/' || map || '/' || id"),
    "buildings": (BuildingRecord, "user || '/' || id"),
    "webhooks": (Webhook, "user || '/' || id"),
    "webhook_deliveries": (WebhookDelivery, "user || '/' || hook || '/' || id"),
    "links": (LinkHistory, "link"),
}
"""Tables of records, with the kind and the key of each."""

_ROBOT = "'robots/' || robots.user || '/' || id"
"""Place of a robot's record."""

_NOT_SHARED = "DELETE FROM robot_shares WHERE user = ? AND robot = ?"


class SqliteStore(
    SqliteIdentities,
    SqlitePlans,
    SqliteHistory,
    SqlitePeople,
    SqliteTasks,
    SqliteBuildings,
    SqliteWebhooks,
    SqliteLeases,
    RobotShares,
):
    """A ``Store`` in an SQLite file, which any number of threads and processes may use at once.

    Parameters
    ----------
    path : Path
        The file; it and its folder are created if they are missing.
    granularity : int
        Length from which segments of plans are shared, about [waypoints].
    busy_timeout : float
        Time limit to wait for the write transaction of another process [s].

    Raises
    ------
    Unavailable
        The file cannot be used; the message says why and what to do.
    """

    def __init__(self, path: Path, granularity: int = GRANULARITY, busy_timeout: float = 5.0) -> None:
        self._connections = SqliteConnections(path, busy_timeout)
        SqliteIdentities.__init__(self, self._connections)
        SqlitePlans.__init__(self, self._connections, granularity)
        SqliteHistory.__init__(self, self._connections)
        SqlitePeople.__init__(self, self._connections)
        SqliteTasks.__init__(self, self._connections)
        SqliteBuildings.__init__(self, self._connections)
        SqliteWebhooks.__init__(self, self._connections)
        SqliteLeases.__init__(self, self._connections)

    def close(self) -> None:
        """Close the file."""
        self._connections.close()

    def all_records(self) -> Iterator[tuple[bytes, type[msgspec.Struct], str]]:
        """Yield all records with their kinds and places, damaged ones included; plans are not among them."""
        for table, (kind, place) in _RECORDS.items():
            with self._connections.reading() as connection:
                rows = connection.execute(f"SELECT record, {place} FROM {table} ORDER BY 2").fetchall()
            yield from ((data, kind, f"{table}/{key}") for data, key in rows)

    def file_faults(self) -> Iterator[str]:
        """Yield what is damaged in the file: pages, indexes, values of a wrong type, plans and their segments."""
        with self._connections.reading() as connection:
            rows = connection.execute("PRAGMA integrity_check").fetchall()
        yield from (text for (text,) in rows if text != "ok")
        yield from self.plan_faults()

    def shrink_log(self) -> None:
        """Move the write-ahead log into the file and empty it, to free space; does nothing if that is not possible."""
        self._connections.shrink_log()

    # -- users ---------------------------------------------------------------------------------------------------------

    def add_user(self, user: User) -> None:
        """Add a user; ``Conflict`` if the id is taken."""
        check_name("user", user.id)
        if not self._write("INSERT INTO users VALUES (?, ?) ON CONFLICT DO NOTHING", user.id, encode(user)):
            raise Conflict(f"user {user.id!r} already exists: choose another id")

    def user(self, user_id: str) -> User:
        """Return a user; ``NotFound`` if it does not exist."""
        check_name("user", user_id)
        query = "SELECT record, 'users/' || id FROM users WHERE id = ?"
        return self._one(User, ("user", user_id), query, user_id)

    def users(self, *, after: str = "", limit: int | None = None) -> list[User]:
        """Return users, sorted by id."""
        query = "SELECT record, 'users/' || id FROM users WHERE id > ? ORDER BY id"
        return self._all(User, query, after, limit=limit)

    def change_user(self, user: User, *, keep_token: str | None = None) -> None:
        """Replace a user; a new password removes all of the user's tokens but one."""
        check_name("user", user.id)
        with self._connections.writing() as connection:
            row = connection.execute("SELECT record FROM users WHERE id = ?", (user.id,)).fetchone()
            if row is None:
                raise NotFound("user", user.id)
            connection.execute("UPDATE users SET record = ? WHERE id = ?", (encode(user), user.id))
            if decode(row[0], User, f"users/{user.id}").password_hash != user.password_hash:
                others = "DELETE FROM tokens WHERE user = ? AND hash IS NOT ?"
                connection.execute(others, (user.id, keep_token))

    def remove_user(self, user_id: str) -> None:
        """Remove a user with all that belongs to it; ``NotFound`` if it does not exist."""
        check_name("user", user_id)
        with self._connections.writing() as connection:
            if not connection.execute("DELETE FROM users WHERE id = ?", (user_id,)).rowcount:
                raise NotFound("user", user_id)
            for table in _OF_USER:
                connection.execute(f"DELETE FROM {table} WHERE user = ?", (user_id,))

    def add_token(self, token: Token) -> None:
        """Store a token; ``NotFound`` if its user does not exist."""
        check_name("token", token.hash)
        check_name("user", token.user)
        insert = "INSERT OR REPLACE INTO tokens SELECT ?, id, ?, ? FROM users WHERE id = ?"
        if not self._write(insert, token.hash, token.expires, encode(token), token.user):
            raise NotFound("user", token.user)

    def token(self, token_hash: str) -> Token:
        """Return a token, expired or not; ``NotFound`` if it does not exist."""
        check_name("token", token_hash)
        query = "SELECT record, 'tokens/' || hash FROM tokens WHERE hash = ?"
        return self._one(Token, ("token", token_hash), query, token_hash)

    def tokens(self, user_id: str, *, after: str = "", limit: int | None = None) -> list[Token]:
        """Return the tokens of a user, sorted by hash."""
        check_name("user", user_id)
        query = "SELECT record, 'tokens/' || hash FROM tokens WHERE user = ? AND hash > ? ORDER BY hash"
        return self._all(Token, query, user_id, after, limit=limit)

    def remove_token(self, token_hash: str) -> None:
        """Remove a token; ``NotFound`` if it does not exist."""
        check_name("token", token_hash)
        if not self._write("DELETE FROM tokens WHERE hash = ?", token_hash):
            raise NotFound("token", token_hash)

    def remove_tokens(self, *, expired_before: float) -> int:
        """Remove the tokens that expired before a time [s since the epoch]; return their number."""
        return self._write("DELETE FROM tokens WHERE expires < ?", expired_before)

    # -- robots --------------------------------------------------------------------------------------------------------

    def put_robot(self, record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        """Store a robot; ``Conflict`` if the stored record is not ``instead_of``."""
        check_name("user", record.user)
        check_name("robot", record.id)
        check_robot_map(record.map)
        data = encode(record)
        with self._connections.writing() as connection:
            query = f"SELECT record, {_ROBOT} FROM robots WHERE user = ? AND id = ?"
            row = connection.execute(query, (record.user, record.id)).fetchone()
            if instead_of is not None and (row is None or decode(row[0], RobotRecord, row[1]) != instead_of):
                raise Conflict(f"robot {record.id!r} has been changed meanwhile: read it again and retry")
            connection.execute("INSERT OR REPLACE INTO robots VALUES (?, ?, ?)", (record.user, record.id, data))
            connection.execute(_NOT_SHARED, (record.user, record.id))
            shares = ((share.to, record.user, record.id) for share in record.shares)
            connection.executemany("INSERT OR IGNORE INTO robot_shares VALUES (?, ?, ?)", shares)
        return row is None

    def robot(self, user: str, robot_id: str) -> RobotRecord:
        """Return a robot; ``NotFound`` if it does not exist."""
        key = _robot_key(user, robot_id)
        query = f"SELECT record, {_ROBOT} FROM robots WHERE user = ? AND id = ?"
        return self._one(RobotRecord, ("robot", robot_id), query, *key)

    def robots(self, user: str, *, after: str = "", limit: int | None = None) -> list[RobotRecord]:
        """Return the robots of a user, sorted by id."""
        check_name("user", user)
        query = f"SELECT record, {_ROBOT} FROM robots WHERE user = ? AND id > ? ORDER BY id"
        return self._all(RobotRecord, query, user, after, limit=limit)

    def robots_shared_with(
        self, grantee: str, *, after: tuple[str, str] = ("", ""), limit: int | None = None
    ) -> list[RobotRecord]:
        """Return the robots that are shared with a user or a group, sorted by their user and id."""
        query = f"""SELECT record, {_ROBOT}
                   FROM robot_shares AS shares JOIN robots ON robots.user = shares.user AND id = robot
                   WHERE grantee = ? AND (shares.user, robot) > (?, ?) ORDER BY shares.user, robot"""
        return self._all(RobotRecord, query, check_grantee(grantee), *after, limit=limit)

    def remove_robot(self, user: str, robot_id: str) -> None:
        """Remove a robot, its URDF and its clone's checkpoint; ``NotFound`` if it does not exist."""
        key = _robot_key(user, robot_id)
        with self._connections.writing() as connection:
            if not connection.execute("DELETE FROM robots WHERE user = ? AND id = ?", key).rowcount:
                raise NotFound("robot", robot_id)
            connection.execute("DELETE FROM urdfs WHERE user = ? AND robot = ?", key)
            connection.execute(_NOT_SHARED, key)
            _remove_clone(connection, key)

    def put_urdf(self, user: str, robot_id: str, urdf: bytes) -> bool:
        """Store the URDF of a robot; return whether it had none. ``NotFound`` if the robot does not exist."""
        key = _robot_key(user, robot_id)
        with self._connections.writing() as connection:
            is_new = connection.execute("SELECT 1 FROM urdfs WHERE user = ? AND robot = ?", key).fetchone() is None
            insert = "INSERT OR REPLACE INTO urdfs SELECT user, id, ? FROM robots WHERE user = ? AND id = ?"
            if not connection.execute(insert, (urdf, *key)).rowcount:
                raise NotFound("robot", robot_id)
        return is_new

    def urdf(self, user: str, robot_id: str) -> bytes:
        """Return the URDF of a robot; ``NotFound`` if it has none."""
        key = _robot_key(user, robot_id)
        with self._connections.reading() as connection:
            row = connection.execute("SELECT urdf FROM urdfs WHERE user = ? AND robot = ?", key).fetchone()
        if row is None:
            raise NotFound("URDF of robot", robot_id)
        return bytes(row[0])

    def remove_urdf(self, user: str, robot_id: str) -> None:
        """Remove the URDF of a robot; ``NotFound`` if it has none."""
        if not self._write("DELETE FROM urdfs WHERE user = ? AND robot = ?", *_robot_key(user, robot_id)):
            raise NotFound("URDF of robot", robot_id)

    # -- clones --------------------------------------------------------------------------------------------------------

    def save_clone(self, checkpoint: CloneCheckpoint, change: CloneLogChange | None = None) -> None:
        """Store a checkpoint in place of the previous one, and change a log."""
        key = _robot_key(checkpoint.user, checkpoint.robot)
        with self._connections.writing() as connection:
            connection.execute("INSERT OR REPLACE INTO clones VALUES (?, ?, ?)", (*key, encode(checkpoint)))
            if change is not None:
                rows = ((*key, change.log, number, data) for number, data in change.entries.items())
                connection.executemany("INSERT OR REPLACE INTO clone_logs VALUES (?, ?, ?, ?, ?)", rows)
                gone = ((*key, change.log, number) for number in change.obsolete)
                connection.executemany(
                    "DELETE FROM clone_logs WHERE user = ? AND robot = ? AND log = ? AND number = ?", gone
                )

    def clone_log(
        self, user: str, robot: str, log: str, *, after: int = -1, limit: int | None = None
    ) -> list[tuple[int, bytes]]:
        """Return the entries of a log, sorted by number; an empty list if there is no such log."""
        query = """SELECT number, data FROM clone_logs WHERE user = ? AND robot = ? AND log = ? AND number > ?
                   ORDER BY number LIMIT ?"""
        values = (*_robot_key(user, robot), log, after, -1 if limit is None else limit)
        with self._connections.reading() as connection:
            return [(number, bytes(data)) for number, data in connection.execute(query, values)]

    def clone_logs(self, user: str, robot: str) -> list[str]:
        """Return the names of the logs of a clone, sorted."""
        query = "SELECT DISTINCT log FROM clone_logs WHERE user = ? AND robot = ? ORDER BY log"
        with self._connections.reading() as connection:
            return [name for (name,) in connection.execute(query, _robot_key(user, robot))]

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        """Return the last checkpoint of a clone; ``NotFound`` if there is none."""
        key = _robot_key(user, robot)
        query = "SELECT record, 'clones/' || user || '/' || robot FROM clones WHERE user = ? AND robot = ?"
        return self._one(CloneCheckpoint, ("checkpoint of robot", robot), query, *key)

    def remove_clone(self, user: str, robot: str) -> None:
        """Remove the checkpoint and the logs of a clone, if there are any."""
        with self._connections.writing() as connection:
            _remove_clone(connection, _robot_key(user, robot))

    # -- internals -----------------------------------------------------------------------------------------------------

    def _write(self, statement: str, *values: Any) -> int:
        with self._connections.writing() as connection:
            return connection.execute(statement, values).rowcount

    def _one(self, kind: type[R], sought: tuple[str, str], query: str, *values: Any) -> R:
        with self._connections.reading() as connection:
            row = connection.execute(query, values).fetchone()
        if row is None:
            raise NotFound(*sought)
        return decode(row[0], kind, row[1])

    def _all(self, kind: type[R], query: str, *values: Any, limit: int | None) -> list[R]:
        """Return at most ``limit`` records that can be read, from rows of a record and its place."""
        with self._connections.reading() as connection, closing(connection.execute(query, values)) as rows:
            return decode_readable(rows, kind, limit)


def _remove_clone(connection: Connection, key: tuple[str, str]) -> None:
    for table in ("clones", "clone_logs"):
        connection.execute(f"DELETE FROM {table} WHERE user = ? AND robot = ?", key)


def _robot_key(user: str, robot: str) -> tuple[str, str]:
    return check_name("user", user), check_name("robot", robot)
