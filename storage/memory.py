"""Stores in memory, for tests and for trying things out: gone with the process."""

import threading

from ppaas.errors import Conflict, NotFound
from storage.encoding import decode, encode
from storage.names import check_name
from storage.records import CloneCheckpoint, MapRecord, PlanRecord, RobotRecord, Token, User
from storage.versions import check_map, check_owner, without_files


class MemoryStore:
    """A ``Store`` of dictionaries.

    Robots and clones are kept as bytes: they hold dictionaries, which their giver may go on to change.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users: dict[str, User] = {}
        self._tokens: dict[str, Token] = {}
        self._robots: dict[tuple[str, str], bytes] = {}
        self._plans: dict[str, PlanRecord] = {}
        self._clones: dict[tuple[str, str], bytes] = {}

    def close(self) -> None:
        """Do nothing: there is nothing to let go of."""

    # -- users ---------------------------------------------------------------------------------------------------------

    def add_user(self, user: User) -> None:
        """Keep a new user; ``Conflict`` if the id is taken."""
        check_name("user", user.id)
        with self._lock:
            if user.id in self._users:
                raise Conflict(f"the user {user.id!r} exists already: take another id")
            self._users[user.id] = user

    def user(self, user_id: str) -> User:
        """Return a user; ``NotFound`` if there is none."""
        check_name("user", user_id)
        with self._lock:
            if user_id not in self._users:
                raise NotFound("user", user_id)
            return self._users[user_id]

    def users(self) -> list[User]:
        """Return all users by id."""
        with self._lock:
            return [self._users[key] for key in sorted(self._users)]

    def remove_user(self, user_id: str) -> None:
        """Forget a user with all tokens, robots and checkpoints; ``NotFound`` if there is none."""
        check_name("user", user_id)
        with self._lock:
            if self._users.pop(user_id, None) is None:
                raise NotFound("user", user_id)
            self._tokens = {key: token for key, token in self._tokens.items() if token.user != user_id}
            self._robots = {key: robot for key, robot in self._robots.items() if key[0] != user_id}
            self._clones = {key: clone for key, clone in self._clones.items() if key[0] != user_id}

    def add_token(self, token: Token) -> None:
        """Keep a token of a user; ``NotFound`` if the user is no more."""
        check_name("token", token.hash)
        check_name("user", token.user)
        with self._lock:
            if token.user not in self._users:
                raise NotFound("user", token.user)
            self._tokens[token.hash] = token

    def token(self, token_hash: str) -> Token:
        """Return a token, expired or not; ``NotFound`` if there is none."""
        check_name("token", token_hash)
        with self._lock:
            if token_hash not in self._tokens:
                raise NotFound("token", token_hash)
            return self._tokens[token_hash]

    def remove_tokens(self, *, expired_before: float) -> int:
        """Forget the tokens that expired before a time; return how many."""
        with self._lock:
            expired = [key for key, token in self._tokens.items() if token.expires < expired_before]
            for key in expired:
                del self._tokens[key]
            return len(expired)

    # -- robots --------------------------------------------------------------------------------------------------------

    def put_robot(self, record: RobotRecord) -> None:
        """Keep a robot or change it."""
        check_name("user", record.user)
        check_name("robot", record.id)
        check_name("map", record.map)
        data = encode(record)
        with self._lock:
            self._robots[record.user, record.id] = data

    def robot(self, user: str, robot_id: str) -> RobotRecord:
        """Return a robot; ``NotFound`` if there is none."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if key not in self._robots:
                raise NotFound("robot", robot_id)
            return decode(self._robots[key], RobotRecord)

    def robots(self, user: str | None = None) -> list[RobotRecord]:
        """Return the robots of a user, or all, by user and id."""
        if user is not None:
            check_name("user", user)
        with self._lock:
            return [decode(self._robots[key], RobotRecord) for key in sorted(self._robots) if user in (None, key[0])]

    def remove_robot(self, user: str, robot_id: str) -> None:
        """Forget a robot and its clone's checkpoint; ``NotFound`` if there is none."""
        key = _robot_key(user, robot_id)
        with self._lock:
            if self._robots.pop(key, None) is None:
                raise NotFound("robot", robot_id)
            self._clones.pop(key, None)

    # -- plans ---------------------------------------------------------------------------------------------------------

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan; keeping the same id twice changes nothing."""
        check_name("plan", record.id)
        check_name("map", record.map)
        with self._lock:
            self._plans.setdefault(record.id, record)

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if there is none."""
        check_name("plan", plan_id)
        with self._lock:
            if plan_id not in self._plans:
                raise NotFound("plan", plan_id)
            return self._plans[plan_id]

    def plans(self, map_id: str, limit: int = 100) -> list[PlanRecord]:
        """Return the newest plans of a map, newest first; of the same age, the one kept last first."""
        check_name("map", map_id)
        with self._lock:
            last_first = [plan for plan in reversed(self._plans.values()) if plan.map == map_id]
        return sorted(last_first, key=lambda plan: -plan.created)[: max(limit, 0)]

    # -- clones --------------------------------------------------------------------------------------------------------

    def save_clone(self, checkpoint: CloneCheckpoint) -> None:
        """Keep a checkpoint in place of the one before."""
        key = _robot_key(checkpoint.user, checkpoint.robot)
        data = encode(checkpoint)
        with self._lock:
            self._clones[key] = data

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        """Return the last checkpoint; ``NotFound`` if there is none."""
        key = _robot_key(user, robot)
        with self._lock:
            if key not in self._clones:
                raise NotFound("checkpoint of robot", robot)
            return decode(self._clones[key], CloneCheckpoint)

    def remove_clone(self, user: str, robot: str) -> None:
        """Forget the checkpoint, if there is one."""
        key = _robot_key(user, robot)
        with self._lock:
            self._clones.pop(key, None)


def _robot_key(user: str, robot: str) -> tuple[str, str]:
    return check_name("user", user), check_name("robot", robot)


class MemoryMapStore:
    """A ``MapStore`` of one dictionary."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._maps: dict[str, MapRecord] = {}

    def put_map(self, record: MapRecord) -> None:
        """Publish a map or its new version; ``Conflict`` if it is another owner's."""
        check_map(record)
        with self._lock:
            check_owner(self._maps.get(record.id, record), record)
            self._maps[record.id] = record

    def map(self, map_id: str) -> MapRecord:
        """Return the present version; ``NotFound`` if there is no such map."""
        check_name("map", map_id)
        with self._lock:
            if map_id not in self._maps:
                raise NotFound("map", map_id)
            return self._maps[map_id]

    def map_head(self, map_id: str) -> MapRecord:
        """Return the present version without its files; ``NotFound`` if there is no such map."""
        return without_files(self.map(map_id))

    def maps(self) -> list[MapRecord]:
        """Return the heads of all maps by id."""
        with self._lock:
            return [without_files(self._maps[key]) for key in sorted(self._maps)]

    def remove_map(self, map_id: str) -> None:
        """Forget a map; ``NotFound`` if there is none."""
        check_name("map", map_id)
        with self._lock:
            if self._maps.pop(map_id, None) is None:
                raise NotFound("map", map_id)
