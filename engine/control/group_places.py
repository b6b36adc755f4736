"""Group places: opens and closes the places of group nodes, and calls these nodes.

Coordinators serve robots that track people, traffic nodes serve robots that drive by grants.
"""

import asyncio
import logging
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from engine.control.master_driver import MasterDriver
from engine.control.views import PeopleGroupView
from engine.links.place_link import PlaceLink
from engine.master.places import PlaceRequest, group_key, robot_key
from engine.processes.background import repeat
from engine.specs.containers import GroupNode
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.people_coordination import (
    ConfigurePeopleRequest,
    GetPeopleCountsRequest,
    GetPeopleCountsResponse,
    PeopleState,
    ZoneCount,
)
from ppaas.people.names import PEOPLE_COORDINATOR, tracks_people
from ppaas.people.settings import PeopleSettings

logger = logging.getLogger(__name__)

CORES = 0.25
"""Size of the container of a group's node [cores]."""

PERIOD = 0.5
"""Time between two checks of the groups [s]."""

RETRY, LONGEST_RETRY = 5.0, 60.0
"""Time after which a node that was refused is tried again [s]; for one that keeps failing, it doubles each time up to
the second."""

STEADY = 60.0
"""Time for which a node must run until its failures are forgotten [s]: one that crashes soon after each start is not
tried again as if it had never failed."""

READY_TIMEOUT = 5.0
"""Time to wait for a node that starts [s]."""

ANSWER_TIMEOUT = 5.0
"""Time limit of a call of a node [s], which normally answers within milliseconds."""

Key = tuple[str, str]
"""User and id of the map of a group."""


@dataclass(frozen=True, slots=True)
class GroupKind:
    """Kind of groups.

    Parameters
    ----------
    node : {"people", "traffic"}
        Node that each of them has.
    name : str
        Name of that node in texts.
    services : str
        Beginning of the names of its services.
    takes_part : callable
        Returns whether a robot with these parameters is in the group of its user and map.
    linger : float
        Time for which the node outlives the places of its robots [s].
    absent : str
        Text about a group without robots, and what to do; with ``{user}`` and ``{map}``.
    """

    node: GroupNode
    name: str
    services: str
    takes_part: Callable[[Mapping[str, Any]], bool]
    linger: float
    absent: str


@dataclass(slots=True)
class Group:
    """A group, and the state of its node."""

    robots: dict[str, PlaceRequest]
    link: PlaceLink | None = None
    refusal: PPaaSError | None = None
    retry_at: float = float("-inf")
    failures: int = 0
    runs_since: float = float("inf")
    seen_at: float = float("-inf")


class GroupPlaces:
    """Follows the places of robots, and gives each group of those that take part its node.

    A group is the robots of one user on one published map. The place of its node is opened once the first of them has
    a container, so that no robot waits for it, and closed after the last is gone. A node that is refused, for example
    by the user's quota, is tried again.

    Parameters
    ----------
    kind : GroupKind
    service : MasterDriver
        Opens and closes places.
    clock : callable
        Returns monotonic seconds.
    departed : callable
        Called with a group and a robot of it that goes on on another map.

    Attributes
    ----------
    groups : dict of tuple to Group
        Groups by user and map, those without robots until their node has ended.
    """

    def __init__(
        self,
        kind: GroupKind,
        service: MasterDriver,
        clock: Clock,
        departed: Callable[[Key, str], None] = lambda _key, _robot: None,
    ) -> None:
        self._kind = kind
        self._departed = departed
        self._leaving: set[tuple[Key, str]] = set()
        self._service = service
        self._clock = clock
        self._robots: set[str] = set()
        self.groups: dict[Key, Group] = {}
        self._watch: asyncio.Task[None] | None = None

    def place_opened(self, key: str) -> None:
        """Note a place that was opened or adopted; the next check of the groups handles it."""
        request = self._service.request_of(key)
        if request is None:
            return
        if request.group_node == self._kind.node:
            self.groups.setdefault((request.user, request.map.id), Group({}, seen_at=self._clock()))
        elif self._takes_part(request):
            self._robots.add(key)
        else:
            return
        if self._watch is None:
            self._watch = asyncio.create_task(repeat(self.step, PERIOD))

    def close(self) -> None:
        """Open and close no more places."""
        if self._watch is not None:
            self._watch.cancel()

    async def step(self) -> None:
        """Open places for groups that have robots, and close places of groups that have had none for long enough."""
        now, present = self._clock(), self._present()
        for key in present.keys() - self.groups.keys():
            self.groups[key] = Group({})
        for key, group in tuple(self.groups.items()):
            before, group.robots = group.robots, dict(present.get(key, {}))
            self._leaving |= {(key, robot) for robot in before.keys() - group.robots.keys()}
            if group.robots:
                group.seen_at = now
                self._fill(key, group, now)
            elif now - group.seen_at >= self._kind.linger:
                await self._end(key, Unavailable("no robot of its group is connected"))

        for key, robot in tuple(self._leaving):
            self._see_off(key, robot)

    def _see_off(self, key: Key, robot: str) -> None:
        """Report a robot whose container is on another map, so that none on this one speaks for it any more."""
        user, map_id = key
        container = self._service.containers.of_robot(robot_key(user, robot))
        stays = container is not None and container.map.id == map_id
        if stays and key in self.groups and robot not in self.groups[key].robots:
            return  # its container there has not left yet
        self._leaving.discard((key, robot))
        if container is not None and not stays:
            self._departed(key, robot)

    async def close_map(self, map_id: str) -> None:
        """Close the places of all nodes on a map that no robot uses, so that it can be removed."""
        for key in tuple(self.groups):
            if key[1] == map_id:
                await self._end(key, Unavailable(f"map {map_id!r} is removed"))

    def place(self, user: str, map_id: str) -> PlaceLink | None:
        """Return the place of a group's node, which also outlives its robots for a while; None if it is not open."""
        return self._service.place(group_key(self._kind.node, user, map_id))

    async def call(self, user: str, map_id: str, service: str, request: Message) -> bytes:
        """Call the node of a group; return the answer.

        Raises
        ------
        Unavailable
            The group has no robots and no node, or its node was refused or does not answer.
        PPaaSError
            The node refuses the call; the reason.
        """
        link = self.place(user, map_id)
        if link is None:
            raise self._missing(user, map_id)
        await link.ready(READY_TIMEOUT)
        return await link.call(f"{self._kind.services}/{service}", encode(request), ANSWER_TIMEOUT)

    def absent(self, user: str, map_id: str) -> Unavailable:
        """Return the error about a group without robots."""
        return Unavailable(self._kind.absent.format(user=repr(user), map=repr(map_id)))

    def _missing(self, user: str, map_id: str) -> Unavailable:
        group = self.groups.get((user, map_id))
        if group is None or not group.robots:
            return self.absent(user, map_id)
        reason = group.refusal or Unavailable("its robots are just starting; try again")
        return Unavailable(f"the {self._kind.name} of map {map_id!r} has no container: {reason}")

    async def _end(self, key: Key, reason: PPaaSError) -> None:
        self.groups.pop(key, None)
        await self._service.close_place(group_key(self._kind.node, *key), reason)

    def _present(self) -> Mapping[Key, Mapping[str, PlaceRequest]]:
        """Return the requests of the robots that take part, by group and robot; forget closed places."""
        groups: defaultdict[Key, dict[str, PlaceRequest]] = defaultdict(dict)
        for key in tuple(self._robots):
            request = self._service.request_of(key)
            robot = None if request is None or not self._takes_part(request) else request.robot
            if request is None or robot is None or self._service.place(key) is None:
                self._robots.discard(key)
            # A robot in the queue has no container, so its group needs no node for it yet.
            elif self._service.position(key) is None:
                groups[request.user, request.map.id][robot.id] = request
        return groups

    def _takes_part(self, request: PlaceRequest) -> bool:
        robot = request.robot
        return robot is not None and not robot.new_map and self._kind.takes_part(robot.parameters)

    def _fill(self, key: Key, group: Group, now: float) -> None:
        """Make sure that a group with robots has a node, or that it is known why not."""
        link = self.place(*key)
        if link is None and group.link is not None and group.link.closed is not None:
            wait = min(RETRY * 2.0 ** min(group.failures, 10), LONGEST_RETRY)
            self._refused(key, group, group.link.closed, now + wait)
            group.failures += 1
        if link is None and now >= group.retry_at and any(map(self._is_ready, group.robots.values())):
            link = self._open(key, group, now)
        group.link = link
        if link is None or link.container is None:
            group.runs_since = float("inf")
            return
        group.refusal, group.runs_since = None, min(group.runs_since, now)
        if now - group.runs_since >= STEADY:
            group.failures = 0

    def _is_ready(self, robot: PlaceRequest) -> bool:
        place = self._service.place(robot.key)
        return place is not None and place.container is not None

    def _open(self, key: Key, group: Group, now: float) -> PlaceLink | None:
        robot = next(iter(group.robots.values()))
        try:
            return self._service.open_place(PlaceRequest(key[0], robot.map, CORES, group_node=self._kind.node))
        except PPaaSError as error:
            self._refused(key, group, error, now + RETRY)
            return None

    def _refused(self, key: Key, group: Group, reason: PPaaSError, retry_at: float) -> None:
        if group.refusal is None or str(group.refusal) != str(reason):
            logger.warning("robots of user %s on map %r have no %s: %s", *key, self._kind.name, reason)
        group.refusal, group.retry_at = reason, retry_at


# -- people ------------------------------------------------------------------------------------------------------------

PEOPLE_LINGER = 75.0
"""Time for which a coordinator outlives the places of its robots [s]. By then it has forgotten all people, so that the
store keeps no positions in its last checkpoint."""

PEOPLE_KIND = GroupKind(
    "people",
    "people coordinator",
    PEOPLE_COORDINATOR,
    tracks_people,
    PEOPLE_LINGER,
    "no robot of user {user} tracks people on map {map} now: connect one with a detector of people",
)


class PeopleGroups:
    """Gives each group of robots that track people a coordinator, and calls it; implements ``PeopleCalls``.

    A coordinator that is refused changes nothing for the robots: the reason is in the view of the group.

    Parameters
    ----------
    service : MasterDriver
        Opens and closes places.
    clock : callable
        Returns monotonic seconds.

    Attributes
    ----------
    places : GroupPlaces
        Places of the coordinators.
    """

    def __init__(self, service: MasterDriver, clock: Clock = monotonic) -> None:
        self.places = GroupPlaces(PEOPLE_KIND, service, clock)

    async def views(self) -> list[PeopleGroupView]:
        """Return the groups with robots, by user and map."""
        return [_view(key, group) for key, group in sorted(self.places.groups.items()) if group.robots]

    async def people(self, user: str, map_id: str) -> PeopleState:
        """Return the people whom the robots of a user see on a map."""
        return decode(PeopleState, await self._call(user, map_id, "get_people", Empty()))

    async def counts(self, user: str, map_id: str, since: int) -> list[ZoneCount]:
        """Return the numbers of different people by hour and zone, without hours that ended before a time."""
        answer = await self._call(user, map_id, "get_people_counts", GetPeopleCountsRequest(since))
        return decode(GetPeopleCountsResponse, answer).counts

    async def configure(self, user: str, map_id: str, settings: PeopleSettings) -> None:
        """Make the coordinator of a group use settings, which are stored already.

        A group without a coordinator needs none: each coordinator reads the stored settings when it starts. One that
        was refused is tried again at once, since its settings may have been the reason.
        """
        if self.places.place(user, map_id) is not None:
            text = msgspec.json.encode(settings).decode()
            await self.places.call(user, map_id, "configure_people", ConfigurePeopleRequest(text))
        elif (user, map_id) in self.places.groups:
            self.places.groups[user, map_id].retry_at = float("-inf")

    async def _call(self, user: str, map_id: str, service: str, request: Message) -> bytes:
        group = self.places.groups.get((user, map_id))
        if group is None or not group.robots:
            raise self.places.absent(user, map_id)
        return await self.places.call(user, map_id, service, request)


def _view(key: Key, group: Group) -> PeopleGroupView:
    robots, link = tuple(sorted(group.robots)), group.link
    if link is None or group.refusal is not None:
        return PeopleGroupView(*key, robots, "refused" if group.refusal else "starting", str(group.refusal or ""))
    return PeopleGroupView(*key, robots, "starting" if link.container is None else "ready")
