"""Facade of the engine for the endpoints: passes each request to the part of the engine that answers it."""

from collections.abc import Callable
from functools import partial

from engine.master.places import robot_key
from engine.master.quotas import Quotas
from engine.service.group_places import GroupPlaces
from engine.service.links.place_link import PlaceLink
from engine.service.master_driver import MasterDriver
from engine.service.navigation_client import NavigationClient
from engine.service.news.news import News, NewsKind
from engine.service.news.robot_facts import FactKind, FactSources
from engine.service.people_groups import PeopleGroups
from engine.service.planning.fleet_requests import FleetAnswer, FleetRequest
from engine.service.planning.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.service.planning.plan_rate import PlanRate
from engine.service.planning.planning import Planning
from engine.service.planning_places import PlanningPlaces
from engine.service.robot_navigation import RobotNavigation
from engine.service.robot_nodes import RobotNodes
from engine.service.tasks.robots import TaskRobots
from engine.service.tasks.runner import TaskNews, TaskRunner
from engine.service.traffic_groups import TrafficGroups
from engine.service.views import (
    ContainerView,
    EndpointView,
    GoalView,
    LifelongRobot,
    MachineView,
    MappingRobot,
    PeopleGroupView,
    RobotState,
    UserUsage,
)
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import StartState
from ppaas.diagnosis.observations.facts import Observations
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.health.recorder import RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse
from ppaas.people.settings import PeopleSettings
from storage.ports import Store
from storage.records import Limits, MapRecord, User
from storage.versions import OCTOMAP, YAML


class Cloud:
    """Answers the requests of the endpoints; implements ``endpoints.services.control_plane.ControlPlane``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    quotas : Quotas
        Quotas of the users.

    Attributes
    ----------
    endpoints_of : callable
        Returns the endpoints that are connected to this process.
    master_silence : float
        Time since the master answered [s]; always 0, because the master is in this process.
    """

    master_silence = 0.0

    def __init__(self, driver: MasterDriver, quotas: Quotas) -> None:
        self.quotas = quotas
        self.news = News()
        self.fact_sources = FactSources()
        self.endpoints_of: Callable[[], list[EndpointView]] = list
        self._plan_rate = PlanRate(quotas)
        self._driver = driver
        self._planning_places = PlanningPlaces(driver)
        self._planning = Planning(self._use, driver.start_state)
        self._nodes = RobotNodes(self._place_of)
        self._people, self._traffic = PeopleGroups(driver), TrafficGroups(driver)
        self._navigation = RobotNavigation(driver)
        self._task_news = TaskNews()
        self._task_robots = TaskRobots(driver, partial(NavigationClient, goal_ended=self._task_news.wake.set))

    @property
    def start(self) -> StartState:
        """Whether containers can start, and the kernels that machines compile."""
        return self._driver.start_state()

    def close(self) -> None:
        """Cancel all timers."""
        self._planning_places.close()
        for places in self._groups:
            places.close()
        self._navigation.close()

    def place_opened(self, key: str) -> None:
        """Give the robot of a place the nodes of its groups, and tasks; called for adopted places, too."""
        for places in self._groups:
            places.place_opened(key)
        self._task_robots.place_opened(key)

    def task_runner(self, store: Store) -> TaskRunner:
        """Return what leads the tasks of this cloud, which are in a store."""
        return TaskRunner(store, self._task_robots, self._task_news, self._planning.compute_costs)

    @property
    def _groups(self) -> tuple[GroupPlaces, ...]:
        return self._people.places, self._traffic.places

    async def machines(self) -> list[MachineView]:
        """Return all machines."""
        return self._driver.machines()

    async def endpoints(self) -> list[EndpointView]:
        """Return all endpoints that are connected to the master."""
        return self.endpoints_of()

    async def machine_settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine."""
        return self._driver.administration.settings(machine)

    async def configure_machine(self, machine: str, settings: MachineSettings) -> None:
        """Apply and store settings of a machine."""
        self._driver.administration.configure(machine, settings)

    async def remove_machine(self, machine: str, *, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted again."""
        self._driver.administration.remove(machine, force=force)

    async def admit_machine(self, machine: str) -> None:
        """Accept a removed machine again."""
        self._driver.administration.admit(machine)

    async def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or of all users if None."""
        return self._driver.containers(user)

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or that of a robot, and notify their clients of the reason."""
        if robot is None:
            await self._driver.close_places(user, reason)
        else:
            await self._driver.close_place(robot_key(user, robot), reason)

    async def give_up_container(self, container: str) -> None:
        """End a container; its place gets another."""
        self._driver.give_up_container(container)

    def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored; opens the queued places that they allow."""
        if limits != self.quotas.limits(user):
            self._driver.set_limits(user, limits)

    def announce(self, kind: NewsKind, key: str) -> None:
        """Tell the endpoints that this process has changed a record in the stores."""
        self.news.tell(kind, key)

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the endpoints know of a robot, as JSON."""
        return await self.fact_sources.ask(kind, user, robot)

    def map_changed(self, head: MapRecord) -> None:
        """Let the robots on a map, or with it as a mask, go on with its current version.

        A version without a grid is no map to drive on: they go on with the one before.
        """
        files = head.present.files
        if YAML in files:
            self._driver.map_changed(MapVersion(head.id, head.version), head.present.number, in_space=OCTOMAP in files)

    async def count_paths(self, user: str, paths: int) -> None:
        """Count paths that a user requests; ``QuotaExceeded`` if they are too many."""
        self._plan_rate.take(user, paths)

    async def take_paths(self, user: str, paths: int, ahead: int) -> int:
        """Count paths that a user requests, and further ones if the quota allows; return the number of these."""
        return self._plan_rate.take_ahead(user, paths, ahead)

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        self.quotas.check_container(user, cores)

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        used = self.quotas.used(user)
        return UserUsage(used.containers, used.cores, self._plan_rate.used(user))

    async def resize_container(self, container: str, cores: float) -> None:
        """Change the size of a running container [cores]."""
        self._driver.resize_container(container, cores)

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected."""
        return [self._driver.presence.is_here(robot_key(user, robot)) for user, robot in robots]

    async def robot_state(self, user: str, robot: str) -> RobotState:
        """Return the pose and the active goals of a robot, connected or not."""
        return await self._navigation.state(user, robot)

    async def send_goal(self, user: str, robot: str, pose: Pose2D) -> GoalView:
        """Send a robot to a pose in the frame ``map``."""
        return self._navigation.send_goal(user, robot, pose)

    async def goals(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals that REST sent to a robot since it last connected, oldest first."""
        return self._navigation.goals(user, robot)

    async def goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Return a goal."""
        return self._navigation.goal(user, robot, goal_id)

    async def cancel_goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal."""
        return self._navigation.cancel_goal(user, robot, goal_id)

    async def cancel_goals(self, user: str, robot: str) -> None:
        """Cancel all goals of a robot, also those of other clients."""
        self._navigation.cancel_goals(user, robot)

    def place(self, user: str, robot: str) -> PlaceLink | None:
        """Return the link of a robot's place; None if it has none."""
        return self._driver.place(robot_key(user, robot))

    def planning_place(self, user: str, version: MapVersion, labels: dict[str, str], *, queue: bool) -> PlaceLink:
        """Open the place of a planning container, or use it; see ``PlanningPlaces.use``."""
        return self._planning_places.use(user, version, labels, queue=queue)

    @property
    def leads(self) -> bool:
        """True while this master may give orders."""
        control, _ = self._driver.servers
        return control.mandate.leads()

    @property
    def epoch(self) -> int:
        """Epoch of this master."""
        control, _ = self._driver.servers
        return control.mandate.epoch

    def machine_of_place(self, key: str) -> str | None:
        """Return the machine of the container of a place; None while there is none."""
        return self._driver.machine_of_place(key)

    def is_removed(self, machine: str) -> bool:
        """Return whether an administrator has removed a machine."""
        return self._driver.administration.is_removed(machine)

    def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return self._driver.position(key)

    async def _place_of(self, user: str, robot: str) -> PlaceLink | None:
        return self.place(user, robot)

    async def _use(
        self, user: str, version: MapVersion, labels: dict[str, str], queue: bool
    ) -> tuple[PlaceLink, int | None]:
        place = self.planning_place(user, version, labels, queue=queue)
        return place, self.position(place.key)

    async def node_homes(self, user: str, robot: str) -> list[NodeHome]:
        """Return the home of each node of a robot, and the reason for it."""
        return await self._nodes.homes(user, robot)

    async def run_node(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        """Move a node of a robot to a home, or to the best one."""
        return await self._nodes.run(user, robot, node, home)

    async def observe_robot(self, user: str, robot: str, seconds: float) -> Observations:
        """Return what is observed of a robot, once its clone has watched it for a time [s]."""
        return await self._nodes.observe(user, robot, seconds)

    async def call_recorder(self, user: str, robot: str, service: str, request: Message) -> RecorderState:
        """Start or stop a recording of a robot, or return the state of its recorder."""
        return await self._nodes.recorder(user, robot, service, request)

    async def robot_map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        """Return a page of the pose graph of the map that a robot makes; −1 returns its numbers."""
        return await self._nodes.map(user, robot, offset)

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots that make new maps now, except those that continue a published one."""
        return self._driver.mapping_robots()

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots that continue a published map for life now."""
        return self._driver.lifelong_robots()

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        """Send a page of a joint map to a robot that makes a map."""
        return await self._nodes.use_joint_map(user, robot, page)

    async def robot_octomap(self, user: str, robot: str, request: GetOctomapFileRequest) -> GetOctomapFileResponse:
        """Return a page of the octomap that a robot makes; an empty one if it makes none."""
        return await self._nodes.octomap(user, robot, request)

    async def people_groups(self) -> list[PeopleGroupView]:
        """Return the groups of robots that track people now, and the states of their coordinators."""
        return self._people.views()

    async def people(self, user: str, map: str) -> PeopleState:  # noqa: A002
        """Return the people whom the robots of a user see on a map."""
        return await self._people.people(user, map)

    async def people_counts(self, user: str, map: str, since: int) -> list[ZoneCount]:  # noqa: A002
        """Return the numbers of different people by hour and zone, without hours that ended before a time."""
        return await self._people.counts(user, map, since)

    async def configure_people(self, user: str, map: str, settings: PeopleSettings) -> None:  # noqa: A002
        """Make the coordinator of a user's robots on a map use settings, which are stored already."""
        await self._people.configure(user, map, settings)

    async def traffic(self, user: str, map: str) -> TrafficState:  # noqa: A002
        """Return the traffic of the robots of a user on a map."""
        return await self._traffic.traffic(user, map)

    async def take_out(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        """Take a robot of a user out of the traffic of a map."""
        await self._traffic.take_out(user, map, robot)

    async def put_back(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        """Put a robot of a user back into the traffic of a map."""
        await self._traffic.put_back(user, map, robot)

    async def tasks_changed(self, user: str, map: str) -> None:  # noqa: A002
        """Let the tasks of a user on a map be read again, since one was added or cancelled."""
        self._task_news.tell(user, map)

    async def end_groups(self, map: str) -> None:  # noqa: A002
        """End the people coordinators and traffic nodes of a map that no robot uses and that is removed."""
        for places in self._groups:
            await places.close_map(map)

    async def compute_path(self, user: User, map: MapVersion, request: PathRequest) -> PathAnswer:  # noqa: A002
        """Compute a path in a planning container."""
        return await self._planning.compute_path(user.id, map, request)

    async def compute_costs(self, user: User, map: MapVersion, request: CostRequest) -> CostAnswer:  # noqa: A002
        """Compute the costs from each start to each goal in a planning container."""
        return await self._planning.compute_costs(user.id, map, request)

    async def plan_fleet(self, user: User, map: MapVersion, request: FleetRequest) -> FleetAnswer:  # noqa: A002
        """Plan for a fleet in a planning container."""
        return await self._planning.plan_fleet(user.id, map, request)
