"""Leader of journeys: sends robots to floors of the buildings that they are in, and goes on after a restart."""

import asyncio
import contextlib
import logging
import secrets
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from msgspec.structs import replace

from engine.control.journeys.calls import JOURNEY
from engine.control.journeys.kept import KeptJourneys, keep_journeys, kept_journeys
from engine.control.journeys.site import JourneySite, Rider, SiteHooks
from engine.control.master_driver import MasterDriver
from engine.control.planning.building_requests import BuildingScene, BuildingSpot, KeptLengths
from engine.control.planning.buildings import BuildingPlanning
from engine.control.planning.planning import Planning
from engine.control.robot_navigation import NavigationClient
from engine.control.robot_sessions import RobotSessions
from engine.control.views import GoalView
from engine.devices.hosts import DeviceHosts
from engine.links.place_link import PlaceLink
from engine.master.places import robot_key
from engine.processes.background import cancel_all
from engine.specs.containers import MapVersion
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import BuildingLayout, Place, layout_of
from ppaas.buildings.lifts.states import LiftRide
from ppaas.buildings.planning.times import Traveller
from ppaas.clock import Clock, epoch
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from storage.buildings.records import BuildingRecord
from storage.ports import MapStore, Store
from storage.versions import ZONES

logger = logging.getLogger(__name__)

KEPT = 100
"""Number of journeys of a robot that are remembered, also after their end."""


class RidingRobot:
    """Robot on a journey, by a client of its place.

    Parameters
    ----------
    driver : MasterDriver
        Has the link of its place.
    sessions : RobotSessions
        Moves its clone to other maps.
    store : Store
        Has its file.
    journey : Journey
        Its journey.
    ended : callable
        Called with each goal that has ended.
    """

    def __init__(
        self,
        driver: MasterDriver,
        sessions: RobotSessions,
        store: Store,
        journey: Journey,
        ended: Callable[[GoalView], None],
    ) -> None:
        self._driver, self._sessions, self._store = driver, sessions, store
        self._user, self._robot, self._ended = journey.user, journey.robot, ended
        self._key = robot_key(journey.user, journey.robot)
        self._client: NavigationClient | None = None
        self._container, self._since = "", 0.0

    @property
    def is_here(self) -> bool:
        """Whether the robot is connected, and has a container."""
        return self._driver.presence.is_here(self._key) and self.map != ""

    @property
    def map(self) -> str:
        """Map that its container is on; empty while it has none that is ready."""
        container = self._driver.containers.of_robot(self._key)
        if container is None or container.state != "ready":
            return ""
        if container.id != self._container:  # what the one before said is of another map, maybe
            self._container, self._since = container.id, epoch()
        return container.map.id

    @property
    def pose(self) -> Place | None:
        """Its pose on that map; None if it is not known, or not any more."""
        client = self._joined()
        if client is None or not self.map or not client.is_newer(self._since):
            return None
        return client.place_now

    def send(self, goal_id: str, pose: Place) -> None:
        """Send a goal, unless one of that id was sent; ``Unavailable`` while the robot is away."""
        client = self._joined()
        if client is None or not self.is_here:
            raise Unavailable(f"robot {self._robot!r} is not connected")
        client.send(Pose2D(*pose), goal_id)

    def cancel(self, goal_id: str) -> None:
        """Cancel a goal, if the robot has a place."""
        client = self._joined()
        if client is not None:
            client.cancel_any(goal_id)

    async def change_map(self, map_id: str, pose: Place) -> None:
        """Let its clone go on on another map, by its file."""
        await asyncio.to_thread(self._store_move, map_id, pose)
        await self._sessions.moved(self._user, self._robot)

    def _store_move(self, map_id: str, pose: Place) -> None:
        record = self._store.robot(self._user, self._robot)
        if record.map != map_id:
            self._store.put_robot(replace(record, map=map_id, initial_pose=pose), instead_of=record)

    def leave(self) -> None:
        """Follow it no longer."""
        if self._client is not None:
            self._client.leave()
            self._client = None

    def _joined(self) -> NavigationClient | None:
        """Return the client of its place; None while it has none."""
        place: PlaceLink | None = self._driver.place(self._key)
        if place is None:
            self.leave()
        elif self._client is None or self._client.place is not place:
            self.leave()
            self._client = NavigationClient(place, goal_ended=lambda _key, goal: self._ended(goal))
        return self._client


class _OpenSite(NamedTuple):
    """Site of a building, its task, and the versions of building and maps that it was opened with."""

    site: JourneySite
    running: asyncio.Task[None]
    version: tuple[object, ...]


class JourneyLeader:
    """Leads journeys in all buildings until cancelled; implements ``JourneyCalls``.

    Parameters
    ----------
    driver : MasterDriver
    sessions : RobotSessions
    store : Store
        Has buildings, robots, and stored journeys.
    map_store : MapStore
        Has the zones of floors.
    planning : Planning
        Plans paths on floors.
    hosts : DeviceHosts
        Hosts of lifts and doors.
    """

    def __init__(
        self,
        driver: MasterDriver,
        sessions: RobotSessions,
        store: Store,
        map_store: MapStore,
        planning: Planning,
        *,
        hosts: DeviceHosts | None = None,
        clock: Clock = epoch,
    ) -> None:
        self._driver, self._sessions = driver, sessions
        self._store, self._map_store, self._clock = store, map_store, clock
        self._hosts = DeviceHosts() if hosts is None else hosts
        self._planning = BuildingPlanning(planning, KeptLengths())
        self._sites: dict[tuple[str, str], _OpenSite] = {}
        self._known: defaultdict[str, dict[str, Journey]] = defaultdict(dict)
        self._opening = asyncio.Lock()

    # -- life ----------------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Go on with stored journeys, and lead all until cancelled."""
        try:
            for record, kept in await asyncio.to_thread(self._stored):
                try:
                    await self._site(record, kept)
                except PPaaSError as error:
                    logger.error("the journeys in building %s do not go on: %s", record.id, error)
            await asyncio.Event().wait()
        finally:
            await cancel_all([known.running for known in self._sites.values()])

    def _stored(self) -> list[tuple[BuildingRecord, KeptJourneys]]:
        records = (record for user in self._store.building_users() for record in self._store.buildings(user))
        found = ((record, kept_journeys(self._store, *record.key)) for record in records)
        return [(record, kept) for record, kept in found if kept.journeys or kept.rides]

    # -- calls ---------------------------------------------------------------------------------------------------------

    async def send_to_floor(self, user: str, robot: str, floor: str, pose: Pose2D) -> GoalView:
        """Send a connected robot to a pose on a floor; see ``JourneyCalls.send_to_floor``."""
        key = robot_key(user, robot)
        request = self._driver.request_of(key)
        if request is None or not self._driver.presence.is_here(key):
            raise Unavailable(f"robot {robot!r} is not connected: it can be sent to a goal once it is")
        record = await asyncio.to_thread(self._building_of, user, request.map.id)
        here = record.building.floor_of_map(request.map.id)
        assert here is not None, "it was found by this map"
        before = next((each for each in self._known[key].values() if each.state == "active"), None)
        site = await self._site(record)
        site.building.floor(floor)
        if before is not None:
            self._check_may_go(before)
            site.cancel(before)
        journey = Journey(
            id=f"{JOURNEY}{secrets.token_hex(6)}", user=user, robot=robot, building=record.id, floor=floor,
            goal=(pose.x, pose.y, pose.theta), on=here.name, since=self._clock(),
        )  # fmt: skip
        self._changed(journey)
        site.begin(journey)
        return view_of(journey)

    @staticmethod
    def _check_may_go(journey: Journey) -> None:
        if journey.is_aboard:
            raise Conflict(f"the robot is in a lift, on journey {journey.id!r}: cancel that, and wait until it is out")

    async def journeys(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals on floors that a robot was sent to, oldest first."""
        return [view_of(journey) for journey in self._known[robot_key(user, robot)].values()]

    async def cancel_journey(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal on a floor; see ``JourneyCalls.cancel_journey``."""
        journey = self._known[robot_key(user, robot)].get(goal_id)
        if journey is None:
            raise NotFound("goal", goal_id[:64])
        if journey.state != "active":
            raise Conflict(f"goal {goal_id!r} has ended: {journey.state}")
        for known in self._sites.values():
            journey = known.site.cancel(journey)
        return view_of(journey)

    # -- buildings -----------------------------------------------------------------------------------------------------

    def _building_of(self, user: str, map_id: str) -> BuildingRecord:
        """Return the building that a map is a floor of, the user's own one first; may block."""
        owners = sorted(self._store.building_users(), key=lambda owner: owner != user)
        for record in (each for owner in owners for each in self._store.buildings(owner)):
            if record.readable_by(user) and record.building.floor_of_map(map_id) is not None:
                return record
        raise InvalidInput(f"map {map_id!r} is no floor of a building of yours: put one with 'ppaas building'")

    async def _site(self, record: BuildingRecord, kept: KeptJourneys | None = None) -> JourneySite:
        """Return the site of a building; one where nobody travels is opened again if building or maps were changed."""
        async with self._opening:
            version = record.present.number, *(await asyncio.to_thread(self._heads, record)).values()
            known = self._sites.get(record.key)
            if known is not None and (known.version == version or not known.site.is_idle):
                return known.site
            layout = await asyncio.to_thread(self._layout, record)
            if known is not None:
                known.running.cancel()
                await asyncio.gather(known.running, return_exceptions=True)
            plan, keep = partial(self._plan, record, layout), partial(self._keep, record.key)
            hooks = SiteHooks(self._rider, plan, keep, self._changed)
            site = JourneySite("/".join(record.key), layout, hooks, self._hosts, kept=kept or KeptJourneys())
            self._sites[record.key] = _OpenSite(site, asyncio.create_task(site.run()), version)
            return site

    def _layout(self, record: BuildingRecord) -> BuildingLayout:
        zones = {}
        for floor in record.building.floors:
            with (
                contextlib.suppress(NotFound),
                self._map_store.open_map(floor.map, only=(ZONES,)) as opened,
            ):
                zones[floor.name] = opened.zones()
        return layout_of(record.building, zones)

    def _rider(self, journey: Journey, ended: Callable[[GoalView], None]) -> Rider:
        return RidingRobot(self._driver, self._sessions, self._store, journey, ended)

    async def _keep(self, key: tuple[str, str], journeys: list[Journey], rides: list[LiftRide]) -> None:
        await asyncio.to_thread(keep_journeys, self._store, key, journeys, rides, self._clock())

    def _changed(self, journey: Journey) -> None:
        known = self._known[robot_key(journey.user, journey.robot)]
        known[journey.id] = journey
        while len(known) > KEPT:
            del known[next(iter(known))]

    async def _plan(
        self, record: BuildingRecord, layout: BuildingLayout, journey: Journey, pose: Place, waits: Mapping[str, float]
    ) -> list[JourneyLeg]:
        heads = await asyncio.to_thread(self._heads, record)
        scene = BuildingScene(layout, heads, Traveller(avoid=frozenset(journey.avoid), waits=waits))
        start, goal = BuildingSpot(journey.on, *pose), BuildingSpot(journey.floor, *journey.goal)
        [route, *_] = await self._planning.plan(journey.user, scene, start, goal)
        return [
            JourneyLeg(
                kind=leg.kind, floor=leg.floor, to_floor=leg.to_floor, start=leg.start, goal=leg.goal,
                length=leg.length, name=leg.name,
            )
            for leg in route.legs
        ]  # fmt: skip

    def _heads(self, record: BuildingRecord) -> dict[str, MapVersion]:
        """Return the current versions of the maps of floors; may block."""
        found = {}
        for floor in record.building.floors:
            with contextlib.suppress(NotFound):
                head = self._map_store.map_head(floor.map)
                found[floor.name] = MapVersion(head.id, head.version)
        return found


def view_of(journey: Journey) -> GoalView:
    """Return a journey as a goal."""
    state = journey.state if journey.state != "failed" else "aborted"
    return GoalView(journey.id, journey.goal, state, journey.text, journey.since, journey.ended)
