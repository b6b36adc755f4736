"""Engine as an endpoint has it: asks the master, and calls containers itself."""

import math
from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from engine.calls.interface import remote
from engine.cloud_client.master_link import MasterLink
from engine.cloud_client.sessions import EndpointPlaces
from engine.control.master_calls.control_plane import (
    ContainerCalls,
    CountPaths,
    MachineCalls,
    MapCalls,
    MoveCalls,
    NeighbourCalls,
    PeopleCalls,
    RobotCalls,
    TaskCalls,
    TrafficCalls,
    UserCalls,
)
from engine.control.master_calls.interface import MasterCalls
from engine.control.news import FactKind, NewsKind
from engine.control.planning.planning import Planning
from engine.control.robot_nodes import RobotNodes
from engine.control.robot_stops import StopCalls
from engine.control.views import ReportedRobot
from engine.links.place_link import PlaceLink
from engine.master.quotas import Quotas
from engine.specs.containers import MapVersion
from engine.specs.start_state import StartState
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable
from storage.records import Limits

# -- paths of users who request many at once ---------------------------------------------------------------------------

AHEAD = 64
"""Number of paths that an endpoint counts ahead of their requests."""

BUSY = 0.1
"""Time between two requests of a user below which paths are counted ahead [s]."""

KEEP_COUNTED = 1.0
"""Time for which they may be requested [s]; the quota is restored as if they had been."""

MAX_USERS = 10_000
"""Number of users who are known here; those whose requests are oldest are forgotten first."""

Take = Callable[[str, int, int], Awaitable[int]]
"""Counts paths of a user and, if the quota allows, a number of further ones; returns how many further ones."""


@dataclass(slots=True)
class _Counted:
    left: int = 0
    until: float = 0.0
    last: float = float("-inf")
    asking: bool = False


class PathsAhead:
    """Counts paths of users here, as far as the master has counted them already.

    Parameters
    ----------
    take : callable
        Counts paths in the master; raises ``QuotaExceeded``.
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, take: Take, clock: Clock) -> None:
        self._take = take
        self._clock = clock
        self._users: BoundedDict[str, _Counted] = BoundedDict(MAX_USERS)

    def forget(self, user: str) -> None:
        """Count the next path of a user in the master, since the quota has changed."""
        self._users.pop(user, None)

    async def count(self, user: str, paths: int) -> None:
        """Count paths that a user requests; raises the errors of ``take``."""
        now = self._clock()
        counted = self._users.get(user)
        if counted is None:
            counted = self._users[user] = _Counted()
        is_busy, counted.last = now - counted.last < BUSY, now
        if now >= counted.until:
            counted.left = 0
        if paths <= counted.left:
            counted.left -= paths
            return
        asks = is_busy and not counted.asking  # one at a time, or each of many clients would take as many
        counted.asking = counted.asking or asks
        try:
            more = await self._take(user, paths, AHEAD if asks else 0)
        finally:
            counted.asking = counted.asking and not asks
        if more:
            counted.left, counted.until = counted.left + more, self._clock() + KEEP_COUNTED


# -- the engine --------------------------------------------------------------------------------------------------------

MAX_LIMITS = 10_000
"""Number of users whose limits are known here; those whose requests are oldest are forgotten first."""

MAX_PLANNED = 10_000
"""Number of planning containers that are known here; those whose requests are oldest are forgotten first."""

KEEP = 20.0
"""Time for which requests go to a planning container without the master [s], which ends idle ones after 120 s."""

_Wanted = tuple[str, MapVersion, tuple[tuple[str, str], ...]]
"""User, map version and labels of a planning container."""

MAX_UNTOLD = 1000
"""Number of changes that wait for a master; the oldest are dropped first."""

CONTAINER_TIMEOUT = 5.0
"""Time to wait until the container of a robot has dialled this endpoint [s]."""


class EndpointCloud:
    """Proxies of the parts of the master, and what the endpoint knows or does itself; implements ``ControlPlane``.

    Parameters
    ----------
    master : MasterLink
    places : EndpointPlaces
    quotas : Quotas
        Limits of the users, as the master has them.
    clock : callable
        Returns monotonic seconds.

    Attributes
    ----------
    start : StartState
        Whether containers can start, and the kernels that machines compile, as the master last said.
    is_replaced : bool
        Whether another master leads, which is not reached from here: this endpoint ends soon.
    """

    def __init__(self, master: MasterLink, places: EndpointPlaces, quotas: Quotas, clock: Clock = monotonic) -> None:
        self._master, self._places, self._clock = master, places, clock
        self._calls = remote(MasterCalls, master)
        self.robots = remote(RobotCalls, master)
        self.moves = remote(MoveCalls, master)
        self.maps = remote(MapCalls, master)
        self.people = remote(PeopleCalls, master)
        self.traffic = remote(TrafficCalls, master)
        self.tasks = remote(TaskCalls, master)
        self.machines = remote(MachineCalls, master)
        self.containers = remote(ContainerCalls, master)
        self.endpoints = remote(NeighbourCalls, master)
        self.users = remote(UserCalls, master)
        self.stops = remote(StopCalls, master)
        self.nodes = RobotNodes(self._place_of)
        self.planning = Planning(self._use_planning, lambda: self.start)
        self.quotas = quotas
        self.start = StartState(ready=False)
        self.is_replaced = False
        self._paths = PathsAhead(self.users.take_paths, clock)
        self.count_paths: CountPaths = self._paths.count
        self._limits: BoundedDict[str, Limits] = BoundedDict(MAX_LIMITS)
        self._planned: BoundedDict[_Wanted, tuple[str, float]] = BoundedDict(MAX_PLANNED)
        self._untold: deque[tuple[NewsKind, str]] = deque(maxlen=MAX_UNTOLD)

    @property
    def master_silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has, or if another one has replaced it."""
        return math.inf if self.is_replaced else self._master.silence

    async def _place_of(self, user: str, robot: str) -> PlaceLink | None:
        try:
            place = self._places.joined(await self._calls.visit(user, robot))
        except Unavailable:
            return None
        await place.ready(CONTAINER_TIMEOUT)
        return place

    async def _use_planning(
        self, user: str, version: MapVersion, labels: dict[str, str], queue: bool
    ) -> tuple[PlaceLink, int | None]:
        """Return the place of a planning container; the master is asked while there is none, and to keep it."""
        wanted = (user, version, tuple(sorted(labels.items())))
        key, until = self._planned.get(wanted, ("", 0.0))
        place = self._places.running(key)
        if place is not None and self._clock() < until:
            return place, None
        joined = await self._calls.open_planning(user, version, labels, queue)
        self._planned[wanted] = joined.key, self._clock() + KEEP
        return self._places.joined(joined), joined.position

    async def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored, here and in the master."""
        if limits != self._limits.get(user):
            self.quotas.set_limits(user, limits)
            self._paths.forget(user)
            self._limits[user] = limits
            self._master.tell(UserCalls.set_limits, user, limits)

    def announce(self, kind: NewsKind, key: str) -> None:
        """Tell the other processes of the cloud that this one has changed a record, now or once there is a master."""
        if not self._master.tell(MasterCalls.announce, kind, key):
            self._untold.append((kind, key))

    def master_found(self) -> None:
        """Send the limits of users, and the changes of records that no master got, to a new master."""
        for user, limits in self._limits.items():
            self._master.tell(UserCalls.set_limits, user, limits)
        untold, self._untold = [*self._untold], deque(maxlen=MAX_UNTOLD)
        for kind, key in untold:
            self.announce(kind, key)

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the other processes of the cloud know of a robot, as JSON; nothing without a master."""
        try:
            return await self._calls.facts(kind, user, robot)
        except Unavailable:
            return []

    async def robot_views(self, robots: list[tuple[str, str]]) -> Sequence[ReportedRobot | None]:
        """Return the states of some robots, by user and id; None for all while no master answers."""
        if self._master.is_up:
            with suppress(Unavailable):
                return await self.robots.views(robots)
        return [None] * len(robots)
