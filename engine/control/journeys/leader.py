"""Leader of journeys: sends robots to floors of the buildings that they are in, and goes on after a restart."""

import asyncio
import contextlib
import logging
import math
import secrets
from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import partial

from msgspec.structs import replace

from engine.control.buildings.building_runner import BuildingAlert
from engine.control.journeys.building_index import BuildingIndex
from engine.control.journeys.calls import JOURNEY
from engine.control.journeys.floor_parts import FloorParts
from engine.control.journeys.kept import KeptJourneys, keep_journeys, kept_journeys
from engine.control.journeys.open_sites import OpenSites
from engine.control.journeys.rider import Rider
from engine.control.journeys.site import JourneySite, SiteHooks
from engine.control.journeys.travellers import traveller_of
from engine.control.journeys.views import LiftWait, SiteView
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
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import BuildingLayout, Place
from ppaas.buildings.lifts.states import LiftRide
from ppaas.buildings.planning.times import Traveller
from ppaas.clock import Clock, epoch
from ppaas.errors import Conflict, InvalidUrdf, MessageTooLarge, NotFound, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.fleet.floors import FindFloorRequest, FindFloorResponse, FloorPart
from ppaas.nodes.amcl.floor_service import FIND_FLOOR
from ppaas.robot_model.describe import describe
from storage.buildings.records import BuildingRecord, all_buildings, no_building_of
from storage.ports import MapStore, Store

logger = logging.getLogger(__name__)

ANSWER = 2.0
"""Time in which a clone answers what needs no scans [s]."""

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

    async def find_floor(self, request: FindFloorRequest) -> FindFloorResponse:
        """Ask its clone on which floor it is."""
        client = self._joined()
        if client is None:
            raise Unavailable(f"robot {self._robot!r} has no container")
        within = ANSWER + (request.timeout if request.floors else 0.0)
        return decode(FindFloorResponse, await client.place.call(FIND_FLOOR.name, encode(request), within))

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


class JourneyLeader:
    """Leads journeys in all buildings until cancelled; implements ``JourneyCalls``.

    Parameters
    ----------
    driver : MasterDriver
    sessions : RobotSessions
    store : Store
        Has buildings, robots, and stored journeys.
    map_store : MapStore
        Has the maps of floors, and their zones.
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
        self._store, self._clock = store, clock
        self._hosts = DeviceHosts() if hosts is None else hosts
        self._planning = BuildingPlanning(planning, KeptLengths())
        self._sites = OpenSites(map_store, lambda key: kept_journeys(store, *key), self._made)
        self._buildings = BuildingIndex(store)
        self._known: defaultdict[str, dict[str, Journey]] = defaultdict(dict)
        self._parts = FloorParts(map_store)

    # -- life ----------------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Go on with stored journeys, and lead all until cancelled."""
        try:
            for record in await asyncio.to_thread(self._stored):
                try:
                    await self._sites.site(record)
                except PPaaSError as error:
                    logger.error("the journeys in building %s do not go on: %s", record.id, error)
            await self._sites.run()
        finally:
            await self._sites.close()

    def _stored(self) -> list[BuildingRecord]:
        found = ((record, kept_journeys(self._store, *record.key)) for record in all_buildings(self._store))
        return [record for record, kept in found if kept.journeys or kept.rides]

    # -- calls ---------------------------------------------------------------------------------------------------------

    async def send_to_floor(self, user: str, robot: str, floor: str, pose: Pose2D) -> GoalView:
        """Send a connected robot to a pose on a floor; see ``JourneyCalls.send_to_floor``."""
        return view_of(await self.lead(user, robot, floor, pose))

    async def lead(self, user: str, robot: str, floor: str, pose: Pose2D, *, goal_id: str = "") -> Journey:
        """Send a connected robot to a pose on a floor; see ``TaskJourneys.lead``."""
        key = robot_key(user, robot)
        if goal_id in self._known[key]:
            return self._known[key][goal_id]
        request = self._driver.request_of(key)
        if request is None or not self._driver.presence.is_here(key):
            raise Unavailable(f"robot {robot!r} is not connected: it can be sent to a goal once it is")
        record = await asyncio.to_thread(self._building_of, user, request.map.id)
        here = record.building.floor_of_map(request.map.id)
        assert here is not None, "it was found by this map"
        before = next((each for each in self._known[key].values() if each.state == "active"), None)
        site = await self._sites.site(record)
        if goal_id in self._known[key]:  # a stored one, which goes on
            return self._known[key][goal_id]
        site.building.floor(floor)
        if before is not None:
            self._check_may_go(before)
            site.cancel(before)
        journey = Journey(
            id=goal_id or f"{JOURNEY}{secrets.token_hex(6)}", user=user, robot=robot, building=record.id,
            floor=floor, goal=(pose.x, pose.y, pose.theta), on=here.name, since=self._clock(),
        )  # fmt: skip
        self._changed(journey)
        site.begin(journey)
        return journey

    @staticmethod
    def _check_may_go(journey: Journey) -> None:
        if journey.is_aboard:
            raise Conflict(f"the robot is in a lift, on journey {journey.id!r}: cancel that, and wait until it is out")

    async def journeys(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals on floors that a robot was sent to, oldest first."""
        return list(map(view_of, self.of_robot(user, robot)))

    def of_robot(self, user: str, robot: str) -> list[Journey]:
        """Return the journeys of a robot that are remembered, oldest first."""
        return list(self._known[robot_key(user, robot)].values())

    async def cancel_journey(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal on a floor; see ``JourneyCalls.cancel_journey``."""
        journey = self._known[robot_key(user, robot)].get(goal_id)
        if journey is None:
            raise NotFound("goal", goal_id[:64])
        if journey.state != "active":
            raise Conflict(f"goal {goal_id!r} has ended: {journey.state}")
        for site in self._sites:
            journey = site.cancel(journey)
        return view_of(journey)

    async def times(
        self, user: str, map_id: str, starts: Sequence[BuildingSpot], goals: Sequence[BuildingSpot]
    ) -> list[list[float | None]]:
        """Return the times in the building of a map, without lifts that serve nobody; see ``TaskJourneys.times``."""
        record = await asyncio.to_thread(self._building_of, user, map_id)
        scene = await self._scene(record, (await self._sites.site(record)).layout, Traveller())
        seconds = await self._planning.costs(user, scene, starts, goals)
        return [[each if math.isfinite(each) else None for each in row] for row in seconds.tolist()]

    # -- buildings -----------------------------------------------------------------------------------------------------

    async def building_state(self, owner: str, building: str) -> SiteView:
        """Return the state of a building; see ``JourneyCalls.building_state``."""
        record = await asyncio.to_thread(self._store.building, owner, building)
        return await (await self._sites.look(record)).view()

    async def lift_waits(self, owner: str, building: str) -> list[LiftWait]:
        """Return the waits for lifts; see ``JourneyCalls.lift_waits``."""
        site = self._sites.get((owner, building))
        return [] if site is None else site.waits

    def _building_of(self, user: str, map_id: str) -> BuildingRecord:
        """Return the building that a map is a floor of; may block."""
        found = self._buildings.with_floor(user, map_id)
        if found is None:
            raise no_building_of(map_id)
        return found

    def _made(self, record: BuildingRecord, layout: BuildingLayout, kept: KeptJourneys) -> JourneySite:
        """Return a site of a building."""
        hooks = SiteHooks(
            self._rider, partial(self._plan, record, layout), partial(self._keep, record.key), self._changed,
            partial(self._parts_of, layout), partial(self._alerted, record), self._driver.counts.lift_waits.add,
        )  # fmt: skip
        return JourneySite("/".join(record.key), layout, hooks, self._hosts, kept=kept)

    def _alerted(self, record: BuildingRecord, alert: BuildingAlert) -> None:
        self._driver.events.building_alerted(record.key, record.building, alert)

    async def _parts_of(self, layout: BuildingLayout, journey: Journey) -> dict[str, FloorPart]:
        return await asyncio.to_thread(self._parts.of, journey, layout)

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
        self, record: BuildingRecord, layout: BuildingLayout, journey: Journey, pose: Place
    ) -> list[JourneyLeg]:
        traveller = await asyncio.to_thread(self._traveller, journey)
        scene = await self._scene(record, layout, traveller)
        start, goal = BuildingSpot(journey.on, *pose), BuildingSpot(journey.floor, *journey.goal)
        [route, *_] = await self._planning.plan(journey.user, scene, start, goal)
        return [
            JourneyLeg(
                kind=leg.kind, floor=leg.floor, to_floor=leg.to_floor, start=leg.start, goal=leg.goal,
                length=leg.length, name=leg.name,
            )
            for leg in route.legs
        ]  # fmt: skip

    async def _scene(self, record: BuildingRecord, layout: BuildingLayout, traveller: Traveller) -> BuildingScene:
        """Return a building with the waits for its lifts that are expected now, where they are known."""
        site, heads = self._sites.get(record.key), await asyncio.to_thread(self._sites.heads, record)
        return BuildingScene(layout, heads, traveller, waits={} if site is None else site.runner.waits())

    def _traveller(self, journey: Journey) -> Traveller:
        """Return what the robot of a journey can do; may block."""
        urdf = None
        with contextlib.suppress(NotFound, InvalidUrdf, MessageTooLarge):  # without one, the body is its model's
            urdf = describe(self._store.urdf(journey.user, journey.robot))
        return traveller_of(self._store.robot(journey.user, journey.robot), urdf, journey.avoid)


def view_of(journey: Journey) -> GoalView:
    """Return a journey as a goal."""
    state = journey.state if journey.state != "failed" else "aborted"
    return GoalView(journey.id, journey.goal, state, journey.text, journey.since, journey.ended)
