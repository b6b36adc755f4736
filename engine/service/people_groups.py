"""People groups: opens the place of a coordinator for the robots of a user on a map that track people, and calls it."""

import asyncio
import logging
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from engine.master.places import PlaceRequest, people_key
from engine.processes.background import repeat
from engine.service.links.place_link import PlaceLink
from engine.service.master_driver import MasterDriver
from engine.service.views import PeopleGroupView
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
from ppaas.people.nodes import tracks_people
from ppaas.people.settings import PeopleSettings

logger = logging.getLogger(__name__)

CORES = 0.25
"""Size of the container of a coordinator [cores]."""

PERIOD = 0.5
"""Time between two checks of the groups [s]."""

LINGER = 75.0
"""Time for which a coordinator outlives the places of its robots [s]. By then it has forgotten all people, so that the
store keeps no positions in its last checkpoint."""

RETRY, LONGEST_RETRY = 5.0, 60.0
"""Time after which a coordinator that was refused is tried again [s]; for one that keeps failing, it doubles each time
up to the second."""

READY_TIMEOUT = 5.0
"""Time to wait for a coordinator that starts [s]."""

ANSWER_TIMEOUT = 5.0
"""Time limit of a call of a coordinator [s], which normally answers within milliseconds."""

Key = tuple[str, str]
"""User and id of the map of a group."""


@dataclass(slots=True)
class _Group:
    """A group, and the state of its coordinator."""

    robots: dict[str, PlaceRequest]
    link: PlaceLink | None = None
    refusal: PPaaSError | None = None
    retry_at: float = float("-inf")
    failures: int = 0
    seen_at: float = float("-inf")


class PeopleGroups:
    """Follows the places of robots, and gives each group of those that track people a coordinator.

    A group is the robots of one user on one published map. Its coordinator's place is opened once the first of them has
    a container, so that no robot waits for it, and closed after the last is gone. A coordinator that is refused, for
    example by the user's quota, changes nothing for the robots: it is tried again, and the reason is in the view of the
    group.

    Parameters
    ----------
    service : MasterDriver
        Opens and closes places.
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, service: MasterDriver, clock: Clock = monotonic) -> None:
        self._service = service
        self._clock = clock
        self._robots: set[str] = set()
        self._groups: dict[Key, _Group] = {}
        self._watch: asyncio.Task[None] | None = None

    def place_opened(self, key: str) -> None:
        """Note a place that was opened or adopted; the next check of the groups handles it."""
        request = self._service.request_of(key)
        if request is None:
            return
        if request.coordinates:
            self._groups.setdefault((request.user, request.map.id), _Group({}, seen_at=self._clock()))
        elif _tracks(request):
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
        """Open the places of groups that have robots, and close those of groups that have had none for `LINGER`."""
        now, present = self._clock(), self._present()
        for key in present.keys() - self._groups.keys():
            self._groups[key] = _Group({})
        for key, group in tuple(self._groups.items()):
            group.robots = dict(present.get(key, {}))
            if group.robots:
                group.seen_at = now
                self._fill(key, group, now)
            elif now - group.seen_at >= LINGER:
                await self._end(key, Unavailable("no robot of its group is connected"))

    async def close_map(self, map_id: str) -> None:
        """Close the places of all coordinators of a map that no robot uses, so that it can be removed."""
        for key in tuple(self._groups):
            if key[1] == map_id:
                await self._end(key, Unavailable(f"map {map_id!r} is removed"))

    async def _end(self, key: Key, reason: PPaaSError) -> None:
        self._groups.pop(key, None)
        await self._service.close_place(people_key(*key), reason)

    def _present(self) -> Mapping[Key, Mapping[str, PlaceRequest]]:
        """Return the requests of the robots that track people, by group and robot; forget closed places."""
        groups: defaultdict[Key, dict[str, PlaceRequest]] = defaultdict(dict)
        for key in tuple(self._robots):
            request = self._service.request_of(key)
            if request is None or request.robot is None or self._service.place(key) is None or not _tracks(request):
                self._robots.discard(key)
            elif self._service.position(key) is None:
                groups[request.user, request.map.id][request.robot.id] = request
        return groups

    def _fill(self, key: Key, group: _Group, now: float) -> None:
        """Make sure that a group with robots has a coordinator, or that it is known why not."""
        link = self._service.place(people_key(*key))
        if link is None and group.link is not None and group.link.closed is not None:
            self._refused(
                key, group, group.link.closed, now + min(RETRY * 2.0 ** min(group.failures, 10), LONGEST_RETRY)
            )
            group.failures += 1
        if link is None and now >= group.retry_at and any(map(self._is_ready, group.robots.values())):
            link = self._open(key, group, now)
        group.link = link
        if link is not None and link.container is not None:
            group.refusal, group.failures = None, 0

    def _is_ready(self, robot: PlaceRequest) -> bool:
        place = self._service.place(robot.key)
        return place is not None and place.container is not None

    def _open(self, key: Key, group: _Group, now: float) -> PlaceLink | None:
        robot = next(iter(group.robots.values()))
        try:
            return self._service.open_place(PlaceRequest(key[0], robot.map, CORES, coordinates=True))
        except PPaaSError as error:
            self._refused(key, group, error, now + RETRY)
            return None

    @staticmethod
    def _refused(key: Key, group: _Group, reason: PPaaSError, retry_at: float) -> None:
        if group.refusal is None or str(group.refusal) != str(reason):
            logger.warning("robots of user %s on map %r have no people coordinator: %s", *key, reason)
        group.refusal, group.retry_at = reason, retry_at

    # -- views and calls -----------------------------------------------------------------------------------------------

    def views(self) -> list[PeopleGroupView]:
        """Return the groups with robots, by user and map."""
        return [_view(key, group) for key, group in sorted(self._groups.items()) if group.robots]

    async def people(self, user: str, map_id: str) -> PeopleState:
        """Return the people whom the robots of a user see on a map.

        Raises
        ------
        Unavailable
            No robot of the group is connected, or its coordinator was refused or does not answer.
        """
        return decode(PeopleState, await self._call(user, map_id, "get_people", Empty()))

    async def counts(self, user: str, map_id: str, since: int) -> list[ZoneCount]:
        """Return the numbers of different people by hour and zone, without hours that ended before a time.

        Raises
        ------
        Unavailable
            As ``people`` raises it.
        """
        answer = await self._call(user, map_id, "get_people_counts", GetPeopleCountsRequest(since))
        return decode(GetPeopleCountsResponse, answer).counts

    async def configure(self, user: str, map_id: str, settings: PeopleSettings) -> None:
        """Make the coordinator of a group use settings, which are stored already.

        A group without a coordinator needs none: each coordinator reads the stored settings when it starts. One that
        was refused is tried again at once, since its settings may have been the reason.

        Raises
        ------
        InvalidInput, NotFound
            The coordinator refuses the settings; NotFound if it has no rule of that name.
        Unavailable
            The coordinator does not answer.
        """
        link = self._service.place(people_key(user, map_id))  # it also outlives its robots for a while
        if link is not None:
            text = msgspec.json.encode(settings).decode()
            await _ask(link, "configure_people", ConfigurePeopleRequest(text))
        elif (user, map_id) in self._groups:
            self._groups[user, map_id].retry_at = float("-inf")

    async def _call(self, user: str, map_id: str, service: str, request: Message) -> bytes:
        group = self._groups.get((user, map_id))
        if group is None or not group.robots:
            raise Unavailable(
                f"no robot of user {user!r} tracks people on map {map_id!r} now: connect one with a detector of people"
            )
        if group.link is None:
            reason = group.refusal or Unavailable("its robots are just starting; try again")
            raise Unavailable(f"the people coordinator of map {map_id!r} has no container: {reason}")
        return await _ask(group.link, service, request)


async def _ask(link: PlaceLink, service: str, request: Message) -> bytes:
    await link.ready(READY_TIMEOUT)
    return await link.call(f"people_coordinator/{service}", encode(request), ANSWER_TIMEOUT)


def _tracks(request: PlaceRequest) -> bool:
    robot = request.robot
    return robot is not None and not robot.new_map and tracks_people(robot.parameters)


def _view(key: Key, group: _Group) -> PeopleGroupView:
    robots, link = tuple(sorted(group.robots)), group.link
    if link is None or group.refusal is not None:
        return PeopleGroupView(*key, robots, "refused" if group.refusal else "starting", str(group.refusal or ""))
    return PeopleGroupView(*key, robots, "starting" if link.container is None else "ready")
