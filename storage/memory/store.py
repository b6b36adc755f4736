"""Everything but maps in memory, for tests and experiments: it is lost when the process ends."""

import threading
from collections.abc import Iterable

from ppaas.errors import Conflict, NotFound
from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.encoding import decode, encode
from storage.history_checks import check_history, check_link
from storage.memory.buildings import MemoryBuildings
from storage.memory.people import MemoryPeople
from storage.memory.plans import MemoryPlans
from storage.memory.tasks import MemoryTasks
from storage.memory.webhooks import MemoryWebhooks
from storage.names import check_name, check_robot_map
from storage.records import CloneCheckpoint, CloneLogChange, Lease, RobotRecord, Token, User, check_lease
from storage.robot_shares import RobotShares
from storage.sharing_records import ProvidedIdentity, check_grantee


class MemoryLeases:
    """A ``LeaseStore`` of a dictionary."""

    def __init__(self) -> None:
        self._lease_lock = threading.Lock()
        self._leases: dict[str, Lease] = {}

    def lease(self, name: str) -> Lease:
        """Return a lease; one of epoch 0 without a holder if it was never taken."""
        check_name("lease", name)
        with self._lease_lock:
            return self._leases.get(name, Lease(name))

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        """Store a lease if the stored one is ``instead_of``; return whether it was."""
        check_lease(lease, instead_of)
        with self._lease_lock:
            if self._leases.get(lease.name, Lease(lease.name)) != instead_of:
                return False
            self._leases[lease.name] = lease
            return True


class MemoryHistory:
    """A ``HistoryStore`` of dictionaries."""

    def __init__(self) -> None:
        self._history_lock = threading.Lock()
        self._history: dict[tuple[str, str, str, int], PlannerHistory] = {}
        self._links: dict[str, LinkHistory] = {}

    def add_history(self, rows: Iterable[PlannerHistory]) -> None:
        """Add each row to the sums of its key, all or none."""
        checked = [check_history(row) for row in rows]
        with self._history_lock:
            for row in checked:
                kept = self._history.get(row.key)
                self._history[row.key] = row if kept is None else kept.plus(row)

    def history(self, map_id: str, version: str | None = None) -> list[PlannerHistory]:
        """Return the rows of a map, or of one of its versions, sorted by key."""
        check_name("map", map_id)
        with self._history_lock:
            rows = sorted(self._history.items())
        return [row for _, row in rows if row.map == map_id and version in (None, row.version)]

    def history_maps(self) -> list[str]:
        """Return the ids of the maps that have rows, sorted."""
        with self._history_lock:
            return sorted({row.map for row in self._history.values()})

    def remove_history(self, map_id: str) -> None:
        """Remove the rows of a map, if it has any."""
        check_name("map", map_id)
        with self._history_lock:
            self._history = {key: row for key, row in self._history.items() if row.map != map_id}

    def put_link(self, row: LinkHistory) -> None:
        """Store the measurements of a link in place of the previous ones."""
        checked = check_link(row)
        with self._history_lock:
            self._links[checked.link] = checked

    def links(self) -> list[LinkHistory]:
        """Return the measurements of all links, sorted by name."""
        with self._history_lock:
            return [self._links[name] for name in sorted(self._links)]


class MemoryStore(
    MemoryPlans, MemoryHistory, MemoryPeople, MemoryTasks, MemoryBuildings, MemoryWebhooks, MemoryLeases, RobotShares
):
    """A ``Store`` of dictionaries.

    Robots and checkpoints are stored as bytes, because they contain dictionaries that a caller may change afterwards.
    """

    def __init__(self) -> None:
        MemoryPlans.__init__(self)
        MemoryHistory.__init__(self)
        MemoryPeople.__init__(self)
        MemoryTasks.__init__(self)
        MemoryBuildings.__init__(self)
        MemoryWebhooks.__init__(self)
        MemoryLeases.__init__(self)
        self._lock = threading.Lock()
        self._users: dict[str, User] = {}
        self._tokens: dict[str, Token] = {}
        self._robots: dict[tuple[str, str], bytes] = {}
        self._urdfs: dict[tuple[str, str], bytes] = {}
        self._clones: dict[tuple[str, str], bytes] = {}
        self._logs: dict[tuple[str, str], dict[str, dict[int, bytes]]] = {}

    def close(self) -> None:
        """Do nothing: there is nothing to close."""

    # -- users ---------------------------------------------------------------------------------------------------------

    def add_user(self, user: User) -> None:
        """Add a user; ``Conflict`` if the id is taken."""
        check_name("user", user.id)
        with self._lock:
            if user.id in self._users:
                raise Conflict(f"user {user.id!r} already exists: choose another id")
            self._users[user.id] = user

    def user(self, user_id: str) -> User:
        """Return a user; ``NotFound`` if it does not exist."""
        check_name("user", user_id)
        with self._lock:
            if user_id not in self._users:
                raise NotFound("user", user_id)
            return self._users[user_id]

    def users(self, *, after: str = "", limit: int | None = None) -> list[User]:
        """Return users, sorted by id."""
        with self._lock:
            return [self._users[key] for key in sorted(self._users) if key > after][:limit]

    def user_with_identity(self, identity: ProvidedIdentity) -> User:
        """Return the user of an identity; ``NotFound`` if none has it."""
        with self._lock:
            known = [user for user in self._users.values() if user.identity == identity]
        if not known:
            raise NotFound("user of identity", identity.subject)
        return min(known, key=lambda user: user.id)

    def change_user(self, user: User, *, keep_token: str | None = None) -> None:
        """Replace a user; a new password removes all of the user's tokens but one."""
        check_name("user", user.id)
        with self._lock:
            if user.id not in self._users:
                raise NotFound("user", user.id)
            if user.password_hash != self._users[user.id].password_hash:
                kept = {key: token for key, token in self._tokens.items() if token.user != user.id or key == keep_token}
                self._tokens = kept
            self._users[user.id] = user

    def remove_user(self, user_id: str) -> None:
        """Remove a user with all that belongs to it; ``NotFound`` if it does not exist."""
        check_name("user", user_id)
        with self._lock:
            if self._users.pop(user_id, None) is None:
                raise NotFound("user", user_id)
            self._tokens = {key: token for key, token in self._tokens.items() if token.user != user_id}
            self._robots = {key: robot for key, robot in self._robots.items() if key[0] != user_id}
            self._urdfs = {key: urdf for key, urdf in self._urdfs.items() if key[0] != user_id}
            self._clones = {key: clone for key, clone in self._clones.items() if key[0] != user_id}
            self._logs = {key: logs for key, logs in self._logs.items() if key[0] != user_id}
            self._forget_people(lambda key: key[0] == user_id)
            self._forget_tasks(lambda group: group[0] == user_id)
            self._forget_buildings(user_id)
            self._forget_webhooks(user_id)

    def add_token(self, token: Token) -> None:
        """Store a token; ``NotFound`` if its user does not exist."""
        check_name("token", token.hash)
        check_name("user", token.user)
        with self._lock:
            if token.user not in self._users:
                raise NotFound("user", token.user)
            self._tokens[token.hash] = token

    def token(self, token_hash: str) -> Token:
        """Return a token, expired or not; ``NotFound`` if it does not exist."""
        check_name("token", token_hash)
        with self._lock:
            if token_hash not in self._tokens:
                raise NotFound("token", token_hash)
            return self._tokens[token_hash]

    def tokens(self, user_id: str, *, after: str = "", limit: int | None = None) -> list[Token]:
        """Return the tokens of a user, sorted by hash."""
        check_name("user", user_id)
        with self._lock:
            mine = [token for token in self._tokens.values() if token.user == user_id and token.hash > after]
        return sorted(mine, key=lambda token: token.hash)[:limit]

    def remove_token(self, token_hash: str) -> None:
        """Remove a token; ``NotFound`` if it does not exist."""
        check_name("token", token_hash)
        with self._lock:
            if self._tokens.pop(token_hash, None) is None:
                raise NotFound("token", token_hash)

    def remove_tokens(self, *, expired_before: float) -> int:
        """Remove the tokens that expired before a time [s since the epoch]; return their number."""
        with self._lock:
            expired = [key for key, token in self._tokens.items() if token.expires < expired_before]
            for key in expired:
                del self._tokens[key]
            return len(expired)

    # -- robots --------------------------------------------------------------------------------------------------------

    def put_robot(self, record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        """Store a robot; ``Conflict`` if the stored record is not ``instead_of``."""
        check_name("user", record.user)
        check_name("robot", record.id)
        check_robot_map(record.map)
        data = encode(record)
        key = record.user, record.id
        with self._lock:
            before = self._robots.get(key)
            if instead_of is not None and (before is None or decode(before, RobotRecord) != instead_of):
                raise Conflict(f"robot {record.id!r} has been changed meanwhile: read it again and retry")
            self._robots[key] = data
        return before is None

    def robot(self, user: str, robot_id: str) -> RobotRecord:
        """Return a robot; ``NotFound`` if it does not exist."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if key not in self._robots:
                raise NotFound("robot", robot_id)
            return decode(self._robots[key], RobotRecord)

    def robots(self, user: str, *, after: str = "", limit: int | None = None) -> list[RobotRecord]:
        """Return the robots of a user, sorted by id."""
        check_name("user", user)
        with self._lock:
            keys = sorted(key for key in self._robots if key[0] == user and key[1] > after)[:limit]
            return [decode(self._robots[key], RobotRecord) for key in keys]

    def robots_shared_with(
        self, grantee: str, *, after: tuple[str, str] = ("", ""), limit: int | None = None
    ) -> list[RobotRecord]:
        """Return the robots that are shared with a user or a group, sorted by their user and id."""
        check_grantee(grantee)
        with self._lock:
            records = [decode(data, RobotRecord) for key, data in sorted(self._robots.items()) if key > after]
        return [record for record in records if grantee in (share.to for share in record.shares)][:limit]

    def remove_robot(self, user: str, robot_id: str) -> None:
        """Remove a robot, its URDF and its clone's checkpoint; ``NotFound`` if it does not exist."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if self._robots.pop(key, None) is None:
                raise NotFound("robot", robot_id)
            self._urdfs.pop(key, None)
            self._clones.pop(key, None)
            self._logs.pop(key, None)

    def put_urdf(self, user: str, robot_id: str, urdf: bytes) -> bool:
        """Store the URDF of a robot; return whether it had none. ``NotFound`` if the robot does not exist."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if key not in self._robots:
                raise NotFound("robot", robot_id)
            is_new = key not in self._urdfs
            self._urdfs[key] = bytes(urdf)
        return is_new

    def urdf(self, user: str, robot_id: str) -> bytes:
        """Return the URDF of a robot; ``NotFound`` if it has none."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if key not in self._urdfs:
                raise NotFound("URDF of robot", robot_id)
            return self._urdfs[key]

    def remove_urdf(self, user: str, robot_id: str) -> None:
        """Remove the URDF of a robot; ``NotFound`` if it has none."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if self._urdfs.pop(key, None) is None:
                raise NotFound("URDF of robot", robot_id)

    # -- clones --------------------------------------------------------------------------------------------------------

    def save_clone(self, checkpoint: CloneCheckpoint, change: CloneLogChange | None = None) -> None:
        """Store a checkpoint in place of the previous one, and change a log."""
        key = _robot_key(checkpoint.user, checkpoint.robot)
        data = encode(checkpoint)
        with self._lock:
            self._clones[key] = data
            if change is not None:
                log = self._logs.setdefault(key, {}).setdefault(change.log, {})
                log.update(change.entries)
                for number in change.obsolete:
                    log.pop(number, None)

    def clone_log(
        self, user: str, robot: str, log: str, *, after: int = -1, limit: int | None = None
    ) -> list[tuple[int, bytes]]:
        """Return the entries of a log, sorted by number; an empty list if there is no such log."""
        key = _robot_key(user, robot)
        with self._lock:
            entries = self._logs.get(key, {}).get(log, {})
            return sorted((number, data) for number, data in entries.items() if number > after)[:limit]

    def clone_logs(self, user: str, robot: str) -> list[str]:
        """Return the names of the logs of a clone, sorted."""
        with self._lock:
            logs = self._logs.get(_robot_key(user, robot), {})
            return sorted(name for name, entries in logs.items() if entries)

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        """Return the last checkpoint of a clone; ``NotFound`` if there is none."""
        key = _robot_key(user, robot)
        with self._lock:
            if key not in self._clones:
                raise NotFound("checkpoint of robot", robot)
            return decode(self._clones[key], CloneCheckpoint)

    def remove_clone(self, user: str, robot: str) -> None:
        """Remove the checkpoint and the logs of a clone, if there are any."""
        key = _robot_key(user, robot)
        with self._lock:
            self._clones.pop(key, None)
            self._logs.pop(key, None)


def _robot_key(user: str, robot: str) -> tuple[str, str]:
    return check_name("user", user), check_name("robot", robot)
