"""The engine in the process of the master: the parts that do the work, by subject."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

import msgspec

from engine.control.fleet_events import LostRobots
from engine.control.group_places import GroupPlaces, PeopleGroups
from engine.control.journeys.calls import TaskJourneys
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
from engine.control.master_calls.interface import ClientJoin, EndpointState, Registration, RequestCounts
from engine.control.master_driver import MasterDriver
from engine.control.news import FactSources, News
from engine.control.other_goals import OtherGoals
from engine.control.planning.plan_rate import PlanRate
from engine.control.planning.planning import Planning
from engine.control.planning_places import PlanningPlaces
from engine.control.robot_navigation import NavigationClient, RobotNavigation
from engine.control.robot_nodes import RobotNodes
from engine.control.robot_stops import RobotStops, StopCalls
from engine.control.tasks.group import KEPT_FOR
from engine.control.tasks.robots import TaskRobots
from engine.control.tasks.runner import TaskNews, TaskRunner
from engine.control.tasks.task_maps import task_map_on
from engine.control.traffic_groups import TrafficGroups
from engine.control.views import EndpointView, GoalView, LifelongRobot, MappingRobot, UserUsage
from engine.links.place_link import PlaceLink
from engine.master.places import robot_key
from engine.master.quotas import Quotas
from engine.protocols.versions import agree
from engine.specs.containers import MapVersion
from engine.specs.robot_maps import is_lifelong
from engine.specs.robot_stops import stops_key
from engine.specs.start_state import StartState
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from storage.ports import CloneStore, MapStore, Store
from storage.records import Limits, MapRecord
from storage.versions import OCTOMAP, YAML

# -- maps in use -------------------------------------------------------------------------------------------------------


class MapsInUse:
    """Moves robots to new versions of their maps, and knows those that make maps; implements ``MapCalls``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    groups : sequence of GroupPlaces
        Places of the nodes of groups.
    """

    def __init__(self, driver: MasterDriver, groups: Sequence[GroupPlaces]) -> None:
        self._driver = driver
        self._groups = groups

    async def changed(self, head: MapRecord) -> None:
        """Move the robots on a map, or with it as a mask, to its current version.

        A version without a grid is no map to drive on: they stay on the one before.
        """
        files = head.present.files
        if YAML in files:
            self._driver.map_changed(MapVersion(head.id, head.version), head.present.number, in_space=OCTOMAP in files)

    async def end_groups(self, map_id: str) -> None:
        """End the people coordinators and traffic nodes of a map."""
        for places in self._groups:
            await places.close_map(map_id)

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots with a running container that make new maps, except those that continue a published one."""
        return [
            MappingRobot(spec.user, robot.id, spec.joint_map)
            for spec, robot in self._driver.containers.running_robots()
            if spec.joint_map
        ]

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots with a running container that continue a published map for life."""
        return [
            LifelongRobot(spec.user, robot.id, robot.continued.id)
            for spec, robot in self._driver.containers.running_robots()
            if robot.continued is not None and is_lifelong(robot.parameters)
        ]


# -- users -------------------------------------------------------------------------------------------------------------


class UserQuotas:
    """Counts what users hold and request, and ends what they hold; implements ``UserCalls``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    quotas : Quotas
        Limits of the users.
    """

    def __init__(self, driver: MasterDriver, quotas: Quotas) -> None:
        self._driver = driver
        self._quotas = quotas
        self._rate = PlanRate(quotas)

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        used = self._quotas.used(user)
        return UserUsage(used.containers, used.cores, self._rate.used(user))

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        self._quotas.check_container(user, cores)

    async def take_paths(self, user: str, paths: int, ahead: int) -> int:
        """Count paths that a user requests, and further ones if the quota allows; return the number of these."""
        return self._rate.take_ahead(user, paths, ahead)

    async def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, and open the queued places that they allow."""
        if limits != self._quotas.limits(user):
            self._driver.set_limits(user, limits)

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or only the place of a robot."""
        if robot is None:
            await self._driver.close_places(user, reason)
        else:
            await self._driver.close_place(robot_key(user, robot), reason)


# -- endpoints ---------------------------------------------------------------------------------------------------------

DISPLACE_TIMEOUT = 4.0
"""Time limit of an endpoint to find out whether the socket of a robot is dead [s]."""

SILENT = 2.5
"""Time since its last report after which an endpoint counts as silent [s]; it reports once a second."""

_NOT_MEASURED = EndpointState(0, 0.0, 0.0, 0)
"""Load of an endpoint that has not reported yet."""


class Neighbour(Protocol):
    """Endpoint, as others see it."""

    registration: Registration | None
    state: EndpointState | None
    beats: int
    heard: float

    def has_robot(self, key: str) -> bool:
        """Return whether the endpoint has the socket of the robot of a place."""
        ...

    def hang_up(self) -> None:
        """Close the link to the endpoint."""
        ...

    async def displace(self, user: str, robot: str, session: str | None, timeout: float) -> None:
        """Let the endpoint displace the socket of a robot, if it is dead or of the same session."""
        ...


class Neighbours:
    """The registered endpoints; implements ``NeighbourCalls``.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self.clock = clock
        self._endpoints: list[Neighbour] = []

    def __iter__(self) -> Iterator[Neighbour]:
        """Iterate over a copy, so that endpoints may come and go meanwhile."""
        return iter(tuple(self._endpoints))

    def beats(self) -> dict[str, int]:
        """Return the number of reports of each endpoint, by name."""
        return {one.registration.endpoint: one.beats for one in self if one.registration is not None}

    async def views(self) -> list[EndpointView]:
        """Return the states of the endpoints."""
        latest = self.clock() - SILENT
        return [
            _view(one.registration, one.state or _NOT_MEASURED, is_silent=one.heard < latest)
            for one in self
            if one.registration is not None
        ]

    def requests(self) -> dict[str, RequestCounts]:
        """Return the requests that each endpoint has answered, by name."""
        return {one.registration.endpoint: one.state.requests for one in self if one.registration and one.state}

    def add(self, endpoint: Neighbour) -> None:
        """Add an endpoint that has registered."""
        self._endpoints.append(endpoint)

    def hang_up(self, name: str) -> None:
        """Close the link to an endpoint; another process with its name may register."""
        for endpoint in self:
            if endpoint.registration is not None and endpoint.registration.endpoint == name:
                endpoint.hang_up()

    def remove(self, endpoint: Neighbour) -> None:
        """Remove an endpoint, if it was added."""
        if endpoint in self._endpoints:
            self._endpoints.remove(endpoint)

    async def displace(self, endpoint: Neighbour, join: ClientJoin) -> None:
        """Let the other endpoint that has the socket of a robot displace it, if it is dead or of the same session."""
        key = robot_key(join.user, join.robot)
        for other in self:
            if other is not endpoint and other.has_robot(key):
                await other.displace(join.user, join.robot, join.session, DISPLACE_TIMEOUT)

    def nearer(self, here: Registration, machine: str | None) -> str:
        """Return the address of the endpoint with the fewest sockets on a machine; empty if ``here`` is there, too."""
        if machine is None or machine == here.at.machine:
            return ""
        there = [
            ((one.state or _NOT_MEASURED).sockets, one.registration.advertised)
            for one in self
            if one.registration is not None and one.registration.at.machine == machine and one.registration.advertised
        ]
        return min(there)[1] if there else ""


def _view(here: Registration, state: EndpointState, *, is_silent: bool) -> EndpointView:
    return EndpointView(
        id=here.endpoint,
        machine=here.at.machine,
        pid=here.pid,
        url=here.advertised or here.url,
        release=here.release,
        sockets=state.sockets,
        frames=state.frames,
        cpu=state.cpu,
        memory=state.memory,
        state="silent" if is_silent else "ready",
        protocol=agree(here.endpoint, here.release, here.protocols),
    )


# -- all parts ---------------------------------------------------------------------------------------------------------


class Cloud:
    """Parts of the master for the endpoints, and for the jobs of this process; implements ``ControlPlane``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    quotas : Quotas
        Limits of the users.
    store : CloneStore
        Has the stops of robots.
    moves : MoveCalls
        Moves robots to other maps.

    Attributes
    ----------
    robot_stops : RobotStops
        Stops of robots.
    neighbours : Neighbours
        The endpoints that are connected to this process.
    planning_places : PlanningPlaces
        Places of planning containers.
    news : News
        Changes of records in the stores.
    fact_sources : FactSources
        Processes that know facts about robots.
    master_silence : float
        Time since the master answered [s]; always 0, because the master is in this process.
    """

    master_silence = 0.0

    def __init__(self, driver: MasterDriver, quotas: Quotas, store: CloneStore, moves: MoveCalls) -> None:
        self.driver, self.quotas, self.moves = driver, quotas, moves
        self.robot_stops = RobotStops(driver, store)
        self.news, self.fact_sources = News(), FactSources()
        self.robot_stops.stored = lambda user: self.news.tell("robot", stops_key(user))
        self.neighbours = Neighbours()
        self.planning_places = PlanningPlaces(driver)
        self.events = driver.events
        self._lost_robots = LostRobots(self.events, driver.request_of)
        driver.presence.listen(self._lost_robots.changed)
        self._other_goals = OtherGoals(driver, self._report_goal)
        self._navigation, self._task_news = RobotNavigation(driver, self._goal_ended), TaskNews()
        people, traffic = PeopleGroups(driver), TrafficGroups(driver)
        self._groups = people.places, traffic.places
        self._task_robots = TaskRobots(driver, partial(NavigationClient, goal_ended=self._task_goal_ended))
        self.robots: RobotCalls = self._navigation
        self.maps: MapCalls = MapsInUse(driver, self._groups)
        self.people: PeopleCalls = people
        self.traffic: TrafficCalls = traffic
        self.tasks: TaskCalls = self._task_news
        self.machines: MachineCalls = driver.administration
        self.containers: ContainerCalls = driver.containers
        self.endpoints: NeighbourCalls = self.neighbours
        self.users: UserCalls = UserQuotas(driver, quotas)
        self.stops: StopCalls = self.robot_stops
        self.nodes = RobotNodes(self._place_of)
        self.planning = Planning(self._use, driver.start_state)
        self.count_paths: CountPaths = partial(self.users.take_paths, ahead=0)
        self.robot_views, self.set_limits = self.robots.views, self.users.set_limits
        self.announce, self.facts = self.news.tell, self.fact_sources.ask

    @property
    def start(self) -> StartState:
        """Whether containers can start, and the kernels that machines compile."""
        return self.driver.start_state()

    def close(self) -> None:
        """Cancel all timers."""
        self.planning_places.close()
        for places in self._groups:
            places.close()
        self._lost_robots.close()
        self._navigation.close()

    def place_opened(self, key: str) -> None:
        """Give the robot of a place the nodes of its groups, tasks and stops; called for adopted places, too."""
        for places in self._groups:
            places.place_opened(key)
        self._task_robots.place_opened(key)
        self._other_goals.place_opened(key)
        self.robot_stops.place_opened(key)

    def task_runner(
        self, store: Store, maps: MapStore, kept_for: float = KEPT_FOR, journeys: TaskJourneys | None = None
    ) -> TaskRunner:
        """Return what leads the tasks of this cloud, which are in a store, for a time after their end [s].

        Robots charge and park at places of its maps, and journeys lead them over the floors of buildings.
        """
        return TaskRunner(
            store, self._task_robots, self._task_news, self.planning.compute_costs,
            changed=self.events.task_changed, kept_for=kept_for, task_map=partial(task_map_on, maps), journeys=journeys,
        )  # fmt: skip

    def hear_goals(self, users: Collection[str]) -> None:
        """Report the ends of all goals of the robots of these users, also of those that other clients sent."""
        self._other_goals.hear(users)

    def _goal_ended(self, key: str, goal: GoalView) -> None:
        self.driver.counts.goals[goal.state] += 1
        self._report_goal(key, msgspec.to_builtins(goal))

    def _task_goal_ended(self, key: str, goal: GoalView) -> None:
        self._goal_ended(key, goal)
        self._task_news.wake.set()

    def _report_goal(self, key: str, goal: Mapping[str, Any]) -> None:
        self.events.goal_ended(key, self.driver.request_of(key), goal)

    async def _place_of(self, user: str, robot: str) -> PlaceLink | None:
        return self.driver.place(robot_key(user, robot))

    async def _use(
        self, user: str, version: MapVersion, labels: dict[str, str], queue: bool
    ) -> tuple[PlaceLink, int | None]:
        place = self.planning_places.use(user, version, labels, queue=queue)
        return place, self.driver.position(place.key)
