"""Robots that a caller reaches: owned or shared, as far as the caller's token goes. All functions here may block."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass

from starlette.concurrency import run_in_threadpool

from endpoints.accounts.tokens import ScopedUser
from endpoints.sharing.access import access_of
from engine.rights.access import Access
from engine.rights.globs import split_address
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, NotFound, NotPermitted
from storage.ports import RobotStore
from storage.records import MapRecord, PlanRecord, RobotRecord, User
from storage.sharing_records import Share, grantees_of
from storage.store_cache import StoreCache

ATTEMPTS = 16
"""Attempts to change the shares of a robot that others change too."""

MAP_TOPIC = "map"
"""Topic of the map: a caller who may subscribe to it may read the map of the robot by REST."""

PLAN_TOPIC = "plan"
"""Topic of the paths of a robot: a caller who may subscribe to it may read its stored plans."""


@dataclass(frozen=True, slots=True)
class ReachedRobot:
    """Robot, and what the caller may do on it."""

    record: RobotRecord
    access: Access

    @property
    def user(self) -> str:
        """Owner of the robot."""
        return self.record.user

    @property
    def id(self) -> str:
        """Id of the robot among its owner's robots."""
        return self.record.id


class ShareCache(StoreCache[tuple[Share, ...]]):
    """Shares of robots that others use now, so that a watch of their sockets does not read the store all the time.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        super().__init__()
        self._clock = clock

    async def shares(self, store: RobotStore, owner: str, robot: str) -> tuple[Share, ...]:
        """Return the shares of a robot; ``NotFound`` if it does not exist."""

        async def load() -> tuple[tuple[Share, ...], float]:
            record = await run_in_threadpool(store.robot, owner, robot)
            return record.shares, math.inf

        return await self.read(_key(owner, robot), self._clock(), load)

    def forget_robot(self, owner: str, robot: str) -> None:
        """Read the shares of a robot again, because they were changed."""
        self.forget(_key(owner, robot))


def reach(store: RobotStore, caller: User, address: str) -> ReachedRobot:
    """Return the robot of an address, ``ROBOT`` or ``OWNER:ROBOT``.

    Raises
    ------
    NotFound
        It does not exist, or is neither the caller's nor shared with the caller.
    NotPermitted
        The caller's token is not for this robot.
    """
    owner, robot = split_address(address, caller.id)
    try:
        record = store.robot(owner, robot)
    except NotFound as error:
        raise NotFound("robot", address) from error
    return ReachedRobot(record, access_of(caller, owner, robot, record.shares))


def own_robots(store: RobotStore, caller: User, *, after: str = "", limit: int | None = None) -> list[RobotRecord]:
    """Return the caller's robots that the caller's token is for, sorted by id."""
    if not isinstance(caller, ScopedUser):
        return store.robots(caller.id, after=after, limit=limit)
    return [one.record for one in _reached(caller, store.robots(caller.id, after=after))][:limit]


def robots_shared_with(
    store: RobotStore, caller: User, *, after: tuple[str, str] = ("", ""), limit: int | None = None
) -> list[ReachedRobot]:
    """Return the robots of others that are shared with a caller, by owner and id."""
    most = None if isinstance(caller, ScopedUser) else limit
    found: dict[tuple[str, str], RobotRecord] = {}
    for grantee in grantees_of(caller.id, caller.groups):
        shared = store.robots_shared_with(grantee, after=after, limit=most)
        found |= {(record.user, record.id): record for record in shared if record.user != caller.id}
    return list(_reached(caller, [found[key] for key in sorted(found)]))[:limit]


def reads_itself(user: User, record: MapRecord) -> bool:
    """Return whether a user may read a map, not only because of a robot on it; an administrator may read all maps."""
    return not isinstance(user, ScopedUser) and (user.role == "admin" or record.readable_by(user.id))


def may_read(store: RobotStore, user: User, record: MapRecord) -> bool:
    """Return whether a user may read a map, also because a robot on it is shared with the user; may block."""
    return reads_itself(user, record) or shows_map(store, user, record)


def shows_map(store: RobotStore, caller: User, head: MapRecord) -> bool:
    """Return whether a robot that the caller reaches shows the caller this map: it is on it, and its owner may read it.

    The caller must be allowed to subscribe to the robot's map.
    """
    reached = robots_shared_with(store, caller)
    if isinstance(caller, ScopedUser):
        reached += _reached(caller, store.robots(caller.id))
    return any(
        one.record.map == head.id and head.readable_by(one.user) and one.access.may_read(MAP_TOPIC) for one in reached
    )


def plans_shown(store: RobotStore, caller: User, head: MapRecord) -> Callable[[PlanRecord], bool]:
    """Return a function that returns whether a caller, who may read a map, may see a stored plan on it; may block.

    A caller who reads the map itself sees all. One whom a robot shows the map sees the caller's own plans, and plans of
    robots whose plans they may subscribe to.
    """
    if reads_itself(caller, head):
        return lambda _plan: True
    reached = [one.record for one in robots_shared_with(store, caller) if one.access.may_read(PLAN_TOPIC)]
    heard = {(record.user, record.id): record.since for record in reached}

    def is_shown(plan: PlanRecord) -> bool:
        return is_author(caller, plan) or heard.get((plan.user, plan.robot or ""), math.inf) <= plan.created

    return is_shown


def is_author(user: User, plan: PlanRecord) -> bool:
    """Return whether a user requested a stored plan; one that is older than the user is of a former user of the id."""
    return user.id == plan.user and user.since <= plan.created


def changed_shares(
    store: RobotStore, record: RobotRecord, change: Callable[[tuple[Share, ...]], tuple[Share, ...]]
) -> RobotRecord:
    """Change with whom a robot is shared, and return its record; no concurrent change of the robot is lost.

    Parameters
    ----------
    store : RobotStore
    record : RobotRecord
        Record of the robot as it was read.
    change : callable
        Takes the shares, and returns the new ones; its errors are raised.

    Raises
    ------
    Conflict
        The robot is changed all the time.
    """
    for _ in range(ATTEMPTS):
        with suppress(Conflict):
            return store.change_shares(record, change(record.shares))
        record = store.robot(record.user, record.id)
    raise Conflict(f"robot {record.id!r} is changed by others all the time: try again")


def end_shares(store: RobotStore, grantee: str) -> list[RobotRecord]:
    """End all shares with a user or a group that is removed, and return the robots."""
    robots = store.robots_shared_with(grantee)
    for record in robots:
        with suppress(NotFound):  # removed meanwhile
            changed_shares(store, record, lambda shares: tuple(share for share in shares if share.to != grantee))
    return robots


def _reached(caller: User, records: list[RobotRecord]) -> Iterator[ReachedRobot]:
    for record in records:
        try:
            yield ReachedRobot(record, access_of(caller, record.user, record.id, record.shares))
        except (NotFound, NotPermitted):
            continue


def _key(owner: str, robot: str) -> str:
    return f"{owner}:{robot}"
