"""Ports: the interfaces of all stores, as the engine and the endpoints use them.

All methods are synchronous and may block; callers on an event loop run them in a thread. A store is thread-safe. Every
method may raise ``Unavailable`` if the store cannot do its work now, and ``InvalidInput`` if a name is not valid
(``storage.names``).

Lists are paginated by key. A page begins after the last key of the previous page (``after`` where keys ascend,
``before`` where the newest records come first) and has at most ``limit`` records; None means all. The key need not
exist any more: records that are added or removed meanwhile neither repeat nor hide others.
"""

from collections.abc import Iterable, Sequence
from typing import Protocol

from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.buildings.records import BuildingStore
from storage.map_port import MapStore
from storage.names import Group
from storage.people import PeopleStore
from storage.plan_query import PlanStoreQuery
from storage.records import (
    CloneCheckpoint,
    CloneLogChange,
    Lease,
    MapTask,
    PlanPart,
    PlanPassage,
    PlanRecord,
    PlanStatistics,
    RobotRecord,
    Token,
    User,
)
from storage.sharing_records import ProvidedIdentity, Share
from storage.webhooks.records import WebhookStore

__all__ = [
    "BuildingStore",
    "CloneStore",
    "HistoryStore",
    "LeaseStore",
    "MapStore",
    "PeopleStore",
    "PlanStore",
    "RobotStore",
    "Store",
    "TaskStore",
    "UserStore",
    "WebhookStore",
]


class UserStore(Protocol):
    """Accounts and their tokens."""

    def add_user(self, user: User) -> None:
        """Add a user; ``Conflict`` if the id is taken."""
        ...

    def user(self, user_id: str) -> User:
        """Return a user; ``NotFound`` if it does not exist."""
        ...

    def users(self, *, after: str = "", limit: int | None = None) -> list[User]:
        """Return users, sorted by id."""
        ...

    def user_with_identity(self, identity: ProvidedIdentity) -> User:
        """Return the user of an identity, the first by id if several have it; ``NotFound`` if none has."""
        ...

    def change_user(self, user: User, *, keep_token: str | None = None) -> None:
        """Replace a user; ``NotFound`` if it does not exist.

        A new password removes all tokens of the user except the one with the hash ``keep_token``, so that a client that
        knew the old password is logged out.
        """
        ...

    def remove_user(self, user_id: str) -> None:
        """Remove a user with all tokens, robots, URDFs, checkpoints, tasks, buildings, webhooks, and settings
        and counts of people.

        The removal is atomic: a later user of the same id never sees data of the former one.
        """
        ...

    def add_token(self, token: Token) -> None:
        """Store a token; ``NotFound`` if its user does not exist."""
        ...

    def token(self, token_hash: str) -> Token:
        """Return a token, expired or not; ``NotFound`` if it does not exist."""
        ...

    def tokens(self, user_id: str, *, after: str = "", limit: int | None = None) -> list[Token]:
        """Return the tokens of a user, sorted by hash."""
        ...

    def remove_token(self, token_hash: str) -> None:
        """Remove a token; ``NotFound`` if it does not exist."""
        ...

    def remove_tokens(self, *, expired_before: float) -> int:
        """Remove the tokens that expired before a time [s since the epoch]; return their number."""
        ...


class RobotStore(Protocol):
    """Robots. Each belongs to a user; two users may have robots of the same id."""

    def put_robot(self, record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        """Store a robot; return whether it is new.

        Raises
        ------
        Conflict
            ``instead_of`` is given and differs from the stored record: another client changed it first.
        """
        ...

    def robot(self, user: str, robot_id: str) -> RobotRecord:
        """Return a robot; ``NotFound`` if it does not exist."""
        ...

    def robots(self, user: str, *, after: str = "", limit: int | None = None) -> list[RobotRecord]:
        """Return the robots of a user, sorted by id."""
        ...

    def change_shares(self, record: RobotRecord, shares: tuple[Share, ...]) -> RobotRecord:
        """Share a robot with these users and groups alone; works while the disk is full.

        Raises
        ------
        Conflict
            ``record`` differs from the stored record: another client changed the robot first.
        """
        ...

    def robots_shared_with(
        self, grantee: str, *, after: tuple[str, str] = ("", ""), limit: int | None = None
    ) -> list[RobotRecord]:
        """Return the robots that are shared with a user or a group, sorted by their user and id, which are the key."""
        ...

    def remove_robot(self, user: str, robot_id: str) -> None:
        """Remove a robot, its URDF and its clone's checkpoint and logs; ``NotFound`` if it does not exist."""
        ...

    def put_urdf(self, user: str, robot_id: str, urdf: bytes) -> bool:
        """Store the URDF of a robot; return whether the robot had none before.

        Raises
        ------
        NotFound
            The robot does not exist.
        """
        ...

    def urdf(self, user: str, robot_id: str) -> bytes:
        """Return the URDF of a robot, byte for byte; ``NotFound`` if it has none."""
        ...

    def remove_urdf(self, user: str, robot_id: str) -> None:
        """Remove the URDF of a robot; ``NotFound`` if it has none."""
        ...


class PlanStore(Protocol):
    """The path plan database: plans, whose equal segments are stored once.

    A place is (x, y) [m] in the map frame. A plan that is not valid (``storage.plan_checks``) raises ``InvalidInput``.
    """

    def add_plan(self, record: PlanRecord) -> None:
        """Add a plan; adding the same id again changes nothing."""
        ...

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Add plans, all or none; return the number of new ones. Of plans with the same id, the first is stored."""
        ...

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Replace a plan by one of the same id.

        Raises
        ------
        Conflict
            The stored plan is not ``instead_of``: another client changed it first.
        NotFound
            There is no plan of this id.
        """
        ...

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan, its poses bit for bit as they were stored; ``NotFound`` if it does not exist."""
        ...

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return the stored plans among these ids, with their poses, by id."""
        ...

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first; the key is ``created`` and the id of a plan."""
        ...

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted; the maps may have been removed."""
        ...

    def find_plans(self, search: PlanStoreQuery, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans that begin near one place and end near another, shortest first.

        Parameters
        ----------
        search : PlanStoreQuery
        limit : int
            Largest number of plans. If there are more, lengths are compared in units of 1/16 m, and any of equally long
            plans may be returned. Of many plans that have the same length, planner and parameters, and begin and end
            within 2 cm of each other, some may be missed.
        """
        ...

    def plans_through(self, search: PlanStoreQuery, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, shortest passage first.

        Parameters are the same as for ``find_plans``. The store examines a bounded number of plans: each result is
        right, but a shorter passage may exist.
        """
        ...

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the shared segments of a plan, in order; ``NotFound`` if the plan does not exist."""
        ...

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans."""
        ...

    def remove_plan(self, plan_id: str) -> None:
        """Remove a plan; ``NotFound`` if it does not exist. Segments that other plans share stay."""
        ...

    def remove_plans(self, map_id: str) -> int:
        """Remove the plans of a map, some at a time; return their number. An interrupted removal can be repeated."""
        ...


class CloneStore(Protocol):
    """Checkpoints of clones, and their logs: entries in the order of their numbers."""

    def save_clone(self, checkpoint: CloneCheckpoint, change: CloneLogChange | None = None) -> None:
        """Store a checkpoint in place of the previous one, and change a log.

        After a failure the entries may be stored without the checkpoint, or obsolete ones be left; try again.
        """
        ...

    def clone_log(
        self, user: str, robot: str, log: str, *, after: int = -1, limit: int | None = None
    ) -> list[tuple[int, bytes]]:
        """Return the entries of a log, sorted by number; an empty list if there is no such log."""
        ...

    def clone_logs(self, user: str, robot: str) -> list[str]:
        """Return the names of the logs of a clone, sorted."""
        ...

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        """Return the last checkpoint of a clone; ``NotFound`` if there is none."""
        ...

    def remove_clone(self, user: str, robot: str) -> None:
        """Remove the checkpoint and the logs of a clone, if there are any."""
        ...


class HistoryStore(Protocol):
    """Planning history: sums over the requests for plans, some hundred rows per map version.

    Rows are added to the sums of their key: map, version, planner and bucket. A row that is added twice counts twice,
    and one that could not be stored is lost: only estimates and tables are derived from them.
    """

    def add_history(self, rows: Iterable[PlannerHistory]) -> None:
        """Add each row to the sums of its key (``storage.history_checks`` validates it)."""
        ...

    def history(self, map_id: str, version: str | None = None) -> list[PlannerHistory]:
        """Return the rows of a map, or of one of its versions, sorted by key."""
        ...

    def history_maps(self) -> list[str]:
        """Return the ids of the maps that have rows, sorted."""
        ...

    def remove_history(self, map_id: str) -> None:
        """Remove the rows of a map, if it has any."""
        ...

    def put_link(self, row: LinkHistory) -> None:
        """Store the measurements of a link in place of the previous ones."""
        ...

    def links(self) -> list[LinkHistory]:
        """Return the measurements of all links, sorted by name."""
        ...


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


class LeaseStore(Protocol):
    """Leases, each of which changes by compare-and-set alone."""

    def lease(self, name: str) -> Lease:
        """Return a lease; one of epoch 0 without a holder if it was never taken."""
        ...

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        """Store a lease if the stored one is ``instead_of``; return whether it was.

        After an error the lease may be stored all the same, also later.
        """
        ...


class Store(
    UserStore,
    RobotStore,
    PlanStore,
    HistoryStore,
    CloneStore,
    PeopleStore,
    TaskStore,
    BuildingStore,
    WebhookStore,
    LeaseStore,
    Protocol,
):
    """A store of everything but maps: many small records."""

    def close(self) -> None:
        """Close files and connections; the store cannot be used afterwards."""
        ...
