"""Engine as an endpoint has it: asks the master, and calls containers itself."""

from collections import deque
from contextlib import suppress

from engine.calls.remote import remote
from engine.endpoint.master_link import MasterLink
from engine.endpoint.paths_ahead import PathsAhead
from engine.endpoint.places import EndpointPlaces
from engine.master.quotas import Quotas
from engine.service.endpoints.control_plane import CountPaths
from engine.service.endpoints.group_calls import PeopleCalls, TaskCalls, TrafficCalls
from engine.service.endpoints.interface import MasterCalls
from engine.service.endpoints.machine_calls import ContainerCalls, MachineCalls, NeighbourCalls
from engine.service.endpoints.map_calls import MapCalls
from engine.service.endpoints.robot_calls import RobotCalls
from engine.service.endpoints.user_calls import UserCalls
from engine.service.links.place_link import PlaceLink
from engine.service.news.news import NewsKind
from engine.service.news.robot_facts import FactKind
from engine.service.planning.planning import Planning
from engine.service.robot_nodes import RobotNodes
from engine.specs.containers import MapVersion
from engine.specs.start_state import StartState
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable
from storage.records import Limits

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
    """

    def __init__(self, master: MasterLink, places: EndpointPlaces, quotas: Quotas, clock: Clock = monotonic) -> None:
        self._master, self._places, self._clock = master, places, clock
        self._calls = remote(MasterCalls, master)
        self.robots = remote(RobotCalls, master)
        self.maps = remote(MapCalls, master)
        self.people = remote(PeopleCalls, master)
        self.traffic = remote(TrafficCalls, master)
        self.tasks = remote(TaskCalls, master)
        self.machines = remote(MachineCalls, master)
        self.containers = remote(ContainerCalls, master)
        self.endpoints = remote(NeighbourCalls, master)
        self.users = remote(UserCalls, master)
        self.nodes = RobotNodes(self._place_of)
        self.planning = Planning(self._use_planning, lambda: self.start)
        self.quotas = quotas
        self.start = StartState(ready=False)
        self._paths = PathsAhead(self.users.take_paths, clock)
        self.count_paths: CountPaths = self._paths.count
        self._limits: BoundedDict[str, Limits] = BoundedDict(MAX_LIMITS)
        self._planned: BoundedDict[_Wanted, tuple[str, float]] = BoundedDict(MAX_PLANNED)
        self._untold: deque[tuple[NewsKind, str]] = deque(maxlen=MAX_UNTOLD)

    @property
    def master_silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has."""
        return self._master.silence

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

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected; None for all while no master answers."""
        if self._master.is_up:
            with suppress(Unavailable):
                return await self.robots.connected(robots)
        return [None] * len(robots)
