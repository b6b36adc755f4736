"""Robots, their URDFs and the checkpoints of their clones in Cassandra."""

import uuid
from collections.abc import Iterable, Sequence
from itertools import islice
from typing import Any

from ppaas.errors import Conflict, NotFound
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.sorted_rows import SortedRows, generation_of, remove_marked
from storage.encoding import decode, decode_readable, encode
from storage.names import check_name, check_robot_map
from storage.records import CloneCheckpoint, CloneLogChange, RobotRecord
from storage.robot_shares import RobotShares
from storage.sharing_records import check_grantee

# Ranges of the numbers of log entries, as they are removed together.

Range = tuple[int, int]
"""Two numbers: the ends of a run, or the bounds of a gap."""


def entry_runs(numbers: Iterable[int]) -> list[Range]:
    """Return the runs of successive numbers as first and last number, in ascending order."""
    runs: list[Range] = []
    for number in sorted(set(numbers)):
        if runs and number == runs[-1][1] + 1:
            runs[-1] = runs[-1][0], number
        else:
            runs.append((number, number))
    return runs


def joined(runs: Sequence[Range], beside: Sequence[Range]) -> list[Range]:
    """Return the gaps that runs leave, as exclusive bounds; runs with no other entry between them leave one gap.

    Parameters
    ----------
    runs : sequence of Range
        Runs of numbers that are removed (``entry_runs``).
    beside : sequence of Range
        The next stored number below and above each run, which may be removed too.
    """
    gaps: list[Range] = []
    for at, (low, high) in enumerate(beside):
        if at and low == runs[at - 1][1]:  # nothing is left between this run and the one before
            gaps[-1] = gaps[-1][0], high
        else:
            gaps.append((low, high))
    return gaps


_KEY = "user = ? AND generation = ? AND id = ?"
_PART = "user = ? AND generation = ? AND robot = ?"
_OWN = "user = ? AND generation = ?"
_ROBOTS = SortedRows("robots", _OWN, "id", "id DESC", "record")
_CLONES = SortedRows("clones", _OWN, "robot", "robot DESC")
_LOG = f"{_PART} AND log = ?"

Key = tuple[str, int, str]
"""User, the user's generation (``storage.cassandra.connection.cluster``), robot."""


class CassandraRobots(RobotShares):
    """A ``RobotStore`` and a ``CloneStore`` in Cassandra.

    A URDF is stored under a unique id, which the robot's row refers to. It is written before the reference, so it
    appears and disappears with that one row.
    """

    _session: CassandraSession

    # -- robots --------------------------------------------------------------------------------------------------------

    def put_robot(self, record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        """Store a robot; ``Conflict`` if the stored record is not ``instead_of``."""
        check_robot_map(record.map)
        key = self._key(record.user, record.id)
        data = encode(record)
        while True:
            row = self._robot_row(key)
            before = row.record if row else None
            if instead_of is not None and (not before or decode(before, RobotRecord, _place(key)) != instead_of):
                raise Conflict(f"robot {record.id!r} has been changed meanwhile: read it again and retry")
            self._list_shares(record.user, record.id, _grantees(record))
            if self._session.write_if(f"UPDATE robots SET record = ? WHERE {_KEY} IF record = ?", data, *key, before):
                self._unlist_shares(record.user, record.id, before)
                return not before

    def robot(self, user: str, robot_id: str) -> RobotRecord:
        """Return a robot; ``NotFound`` if it does not exist."""
        key = self._key(user, robot_id)
        return decode(self._known_robot(key).record, RobotRecord, _place(key))

    def robots(self, user: str, *, after: str = "", limit: int | None = None) -> list[RobotRecord]:
        """Return the robots of a user, sorted by id."""
        check_name("user", user)
        query = "SELECT id, record FROM robots WHERE user = ? AND generation = ? AND id > ?"
        generation = generation_of(self._session, user)
        rows = (row for row in self._session.rows(query, user, generation, after) if row.record)
        placed = ((row.record, _place((user, generation, row.id))) for row in rows)
        return decode_readable(placed, RobotRecord, limit)

    def robots_shared_with(
        self, grantee: str, *, after: tuple[str, str] = ("", ""), limit: int | None = None
    ) -> list[RobotRecord]:
        """Return the robots that are shared with a user or a group, sorted by their user and id."""
        query = "SELECT user, robot FROM robots_by_grantee WHERE grantee = ? AND (user, robot) > (?, ?)"
        listed = self._session.rows(query, check_grantee(grantee), *after)
        keys = (self._key(row.user, row.robot) for row in listed)
        rows = ((key, self._robot_row(key)) for key in keys)
        records = (_record(row.record, key) for key, row in rows if row is not None and row.record)
        shared = (record for record in records if record is not None and grantee in _grantees(record))
        return list(islice(shared, limit))

    def remove_robot(self, user: str, robot_id: str) -> None:
        """Remove a robot, its URDF and its clone's checkpoint; ``NotFound`` if it does not exist."""
        key = self._key(user, robot_id)
        self._known_robot(key)
        self._remove_clone(key)  # first, so that a new robot does not find it
        empty = f"UPDATE robots SET record = 0x, urdf = NULL WHERE {_KEY} IF record = ? AND urdf = ?"
        while row := self._known_robot(key):
            if self._session.write_if(empty, *key, row.record, row.urdf):
                break
        remove_marked(self._session, _ROBOTS, key[:2], robot_id)
        self._unlist_shares(user, robot_id, row.record)
        self._drop_urdf(key, row.urdf)

    # -- URDFs ---------------------------------------------------------------------------------------------------------

    def put_urdf(self, user: str, robot_id: str, urdf: bytes) -> bool:
        """Store the URDF of a robot; return whether it had none. ``NotFound`` if the robot does not exist."""
        key = self._key(user, robot_id)
        self._known_robot(key)
        number = uuid.uuid4()
        insert = "INSERT INTO urdfs (user, generation, robot, id, data) VALUES (?, ?, ?, ?, ?)"
        self._session.write(insert, *key, number, urdf)
        return self._name_urdf(key, number) is None

    def urdf(self, user: str, robot_id: str) -> bytes:
        """Return the URDF of a robot; ``NotFound`` if it has none."""
        key = self._key(user, robot_id)
        while (row := self._robot_row(key)) is not None and row.urdf is not None:
            found = self._session.row(f"SELECT data FROM urdfs WHERE {_PART} AND id = ?", *key, row.urdf)
            if found is not None:  # otherwise another URDF has replaced it meanwhile
                return bytes(found.data)
        raise NotFound("URDF of robot", robot_id)

    def remove_urdf(self, user: str, robot_id: str) -> None:
        """Remove the URDF of a robot; ``NotFound`` if it has none."""
        key = self._key(user, robot_id)
        row = self._robot_row(key)
        if row is None or row.urdf is None or self._name_urdf(key, None) is None:
            raise NotFound("URDF of robot", robot_id)

    # -- clones --------------------------------------------------------------------------------------------------------

    def save_clone(self, checkpoint: CloneCheckpoint, change: CloneLogChange | None = None) -> None:
        """Store a checkpoint in place of the previous one, and change a log.

        New entries are written before the checkpoint, and obsolete ones removed after it.
        """
        key = self._key(checkpoint.user, checkpoint.robot)
        if change is not None:
            write = "INSERT INTO clone_logs (user, generation, robot, log, number, data) VALUES (?, ?, ?, ?, ?, ?)"
            self._session.write_each(write, ((*key, change.log, *entry) for entry in change.entries.items()))
        insert = "INSERT INTO clones (user, generation, robot, record) VALUES (?, ?, ?, ?)"
        self._session.write(insert, *key, encode(checkpoint))
        if change is not None:
            self._drop_entries((*key, change.log), change.obsolete)

    def clone_log(
        self, user: str, robot: str, log: str, *, after: int = -1, limit: int | None = None
    ) -> list[tuple[int, bytes]]:
        """Return the entries of a log, sorted by number; an empty list if there is no such log."""
        query = f"SELECT number, data FROM clone_logs WHERE {_PART} AND log = ? AND number > ?"
        rows = self._session.rows_up_to(limit, query, *self._key(user, robot), log, after)
        return [(row.number, bytes(row.data)) for row in rows]

    def clone_logs(self, user: str, robot: str) -> list[str]:
        """Return the names of the logs of a clone, sorted."""
        rows = self._session.rows(f"SELECT log FROM clone_logs WHERE {_PART}", *self._key(user, robot))
        return sorted({row.log for row in rows})

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        """Return the last checkpoint of a clone; ``NotFound`` if there is none."""
        key = self._key(user, robot)
        row = self._session.row(f"SELECT record FROM clones WHERE {_PART}", *key)
        if row is None:
            raise NotFound("checkpoint of robot", robot)
        return decode(row.record, CloneCheckpoint, f"clones/{user}/{robot}")

    def remove_clone(self, user: str, robot: str) -> None:
        """Remove the checkpoint and the logs of a clone, if there are any."""
        self._remove_clone(self._key(user, robot))

    # -- internals -----------------------------------------------------------------------------------------------------

    def _remove_clone(self, key: Key) -> None:
        query = f"SELECT WRITETIME(record) AS written FROM clones WHERE {_PART}"
        for row in self._session.rows(query, *key):
            statement, values = _CLONES.deletion(self._session, key[:2], key[2], row.written)
            self._session.write(statement, *values)
        self._session.write(f"DELETE FROM clone_logs WHERE {_PART}", *key)

    def _drop_entries(self, log: tuple[str, int, str, str], obsolete: Iterable[int]) -> None:
        """Remove entries of a log by ranges, which cover earlier removals' ranges. A log has one writer at a time."""
        runs = entry_runs(obsolete)
        below = f"SELECT number FROM clone_logs WHERE {_LOG} AND number < ? ORDER BY log DESC, number DESC LIMIT 1"
        above = f"SELECT number FROM clone_logs WHERE {_LOG} AND number > ? LIMIT 1"
        before = self._session.rows_each(below, [(*log, first) for first, _ in runs])
        after = self._session.rows_each(above, [(*log, last) for _, last in runs])
        ends = zip(runs, before, after, strict=True)
        beside = [(_number(low, -1), _number(high, last + 1)) for (_, last), low, high in ends]
        remove = f"DELETE FROM clone_logs WHERE {_LOG} AND number > ? AND number < ?"
        self._session.write_each(remove, [(*log, *bounds) for bounds in joined(runs, beside)])

    def _sweep_robots(self, user: str, generation: int) -> None:
        query = "SELECT id, urdf, record FROM robots WHERE user = ? AND generation = ?"
        for row in self._session.rows(query, user, generation):
            self._unlist_shares(user, row.id, row.record)
            self._drop_urdf((user, generation, row.id), row.urdf)
        for row in self._session.rows("SELECT robot FROM clones WHERE user = ? AND generation = ?", user, generation):
            self._session.write(f"DELETE FROM clone_logs WHERE {_PART}", user, generation, row.robot)
        for table in ("robots", "clones"):
            self._session.write(f"DELETE FROM {table} WHERE user = ? AND generation = ?", user, generation)

    def _list_shares(self, user: str, robot_id: str, grantees: Iterable[str]) -> None:
        insert = "INSERT INTO robots_by_grantee (grantee, user, robot) VALUES (?, ?, ?)"
        self._session.write_each(insert, [(grantee, user, robot_id) for grantee in grantees])

    def _unlist_shares(self, user: str, robot_id: str, before: bytes | None) -> None:
        """List a robot no more for those with whom it was shared by an earlier record, and is not now."""
        earlier = _record(before, self._key(user, robot_id)) if before else None
        if earlier is None or not earlier.shares:
            return
        gone = _grantees(earlier) - self._grantees_now(user, robot_id)
        remove = "DELETE FROM robots_by_grantee WHERE grantee = ? AND user = ? AND robot = ?"
        self._session.write_each(remove, [(grantee, user, robot_id) for grantee in gone])
        # Another client may have shared it again meanwhile.
        back = gone & self._grantees_now(user, robot_id)
        self._list_shares(user, robot_id, back)

    def _grantees_now(self, user: str, robot_id: str) -> set[str]:
        key = self._key(user, robot_id)
        row = self._robot_row(key)
        record = None if row is None or not row.record else _record(row.record, key)
        return set() if record is None else _grantees(record)

    def _key(self, user: str, robot_id: str) -> Key:
        check_name("user", user)
        check_name("robot", robot_id)
        return user, generation_of(self._session, user), robot_id

    def _robot_row(self, key: Key) -> Any:
        return self._session.row(f"SELECT record, urdf FROM robots WHERE {_KEY}", *key)

    def _known_robot(self, key: Key) -> Any:
        row = self._robot_row(key)
        if row is None or not row.record:
            raise NotFound("robot", key[2])
        return row

    def _name_urdf(self, key: Key, number: uuid.UUID | None) -> uuid.UUID | None:
        """Make the robot's row refer to another URDF, or to none; return the id of the previous one."""
        name = f"UPDATE robots SET urdf = ? WHERE {_KEY} IF record = ? AND urdf = ?"
        while True:
            row = self._known_robot(key)
            before: uuid.UUID | None = row.urdf
            if self._session.write_if(name, number, *key, row.record, before):
                self._drop_urdf(key, before)
                return before

    def _drop_urdf(self, key: Key, number: uuid.UUID | None) -> None:
        if number is not None:
            self._session.write(f"DELETE FROM urdfs WHERE {_PART} AND id = ?", *key, number)


def _record(data: bytes, key: Key) -> RobotRecord | None:
    """Return a record; None if it is damaged, which is logged."""
    return next(iter(decode_readable([(data, _place(key))], RobotRecord)), None)


def _place(key: Key) -> str:
    return f"robots/{key[0]}/{key[2]}"


def _number(rows: Sequence[Any], otherwise: int) -> int:
    return next((int(row.number) for row in rows), otherwise)


def _grantees(record: RobotRecord) -> set[str]:
    return {share.to for share in record.shares}
