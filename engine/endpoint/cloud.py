"""Engine as an endpoint has it: asks the master, and calls containers itself."""

from collections import deque
from contextlib import suppress

from engine.endpoint.master_link import MasterLink
from engine.endpoint.paths_ahead import PathsAhead
from engine.endpoint.places import EndpointPlaces
from engine.master.quotas import Quotas
from engine.protocols.refusals import refusal_of
from engine.service.endpoints.cloud_calls import CloudCalls
from engine.service.endpoints.interface import MasterCalls
from engine.service.links.place_link import PlaceLink
from engine.service.news.news import NewsKind
from engine.service.news.robot_facts import FactKind
from engine.service.planning.fleet_requests import FleetAnswer, FleetRequest
from engine.service.planning.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.service.planning.planning import Planning
from engine.service.robot_nodes import RobotNodes
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
from ppaas.bounded_dict import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.diagnosis.observations.facts import Observations
from ppaas.errors import PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.health.recorder import RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse
from ppaas.people.settings import PeopleSettings
from storage.records import Limits, MapRecord, User

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
    """Answers the requests of an endpoint; implements ``endpoints.services.control_plane.ControlPlane``.

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
        self.quotas = quotas
        self._master = master
        self._places = places
        self._nodes = RobotNodes(self._place_of)
        self.start = StartState(ready=False)
        self._planning = Planning(self._use_planning, lambda: self.start)
        self._limits: BoundedDict[str, Limits] = BoundedDict(MAX_LIMITS)
        self._clock = clock
        self._planned: BoundedDict[_Wanted, tuple[str, float]] = BoundedDict(MAX_PLANNED)
        self._paths = PathsAhead(self._take_paths, clock)
        self._untold: deque[tuple[NewsKind, str]] = deque(maxlen=MAX_UNTOLD)

    @property
    def master_silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has."""
        return self._master.silence

    async def _place_of(self, user: str, robot: str) -> PlaceLink | None:
        try:
            place = self._places.joined(await self._master.call(MasterCalls.visit, user, robot))
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
        joined = await self._master.call(MasterCalls.open_planning, user, version, labels, queue)
        self._planned[wanted] = joined.key, self._clock() + KEEP
        return self._places.joined(joined), joined.position

    # -- users ---------------------------------------------------------------------------------------------------------

    def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored, here and in the master."""
        if limits != self._limits.get(user):
            self.quotas.set_limits(user, limits)
            self._paths.forget(user)
            self._limits[user] = limits
            self._master.tell(MasterCalls.set_limits, user, limits)

    async def count_paths(self, user: str, paths: int) -> None:
        """Count paths that a user requests; ``QuotaExceeded`` if they are too many."""
        await self._paths.count(user, paths)

    async def _take_paths(self, user: str, paths: int, ahead: int) -> int:
        return await self._master.call(MasterCalls.take_paths, user, paths, ahead)

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        await self._master.call(CloudCalls.check_container, user, cores)

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        return await self._master.call(CloudCalls.usage, user)

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or that of a robot, and notify their clients of the reason."""
        await self._master.call(MasterCalls.end_places, user, refusal_of(reason), robot)

    # -- machines and containers ---------------------------------------------------------------------------------------

    async def machines(self) -> list[MachineView]:
        """Return all machines."""
        return await self._master.call(CloudCalls.machines)

    async def endpoints(self) -> list[EndpointView]:
        """Return all endpoints that are connected to the master."""
        return await self._master.call(CloudCalls.endpoints)

    async def machine_settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine."""
        return await self._master.call(CloudCalls.machine_settings, machine)

    async def configure_machine(self, machine: str, settings: MachineSettings) -> None:
        """Apply and store settings of a machine."""
        await self._master.call(CloudCalls.configure_machine, machine, settings)

    async def remove_machine(self, machine: str, *, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted again."""
        await self._master.call(MasterCalls.remove_machine, machine, force)

    async def admit_machine(self, machine: str) -> None:
        """Accept a removed machine again."""
        await self._master.call(CloudCalls.admit_machine, machine)

    async def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or of all users if None."""
        return await self._master.call(CloudCalls.containers, user)

    async def give_up_container(self, container: str) -> None:
        """End a container; its place gets another."""
        await self._master.call(CloudCalls.give_up_container, container)

    async def resize_container(self, container: str, cores: float) -> None:
        """Change the size of a running container [cores]."""
        await self._master.call(CloudCalls.resize_container, container, cores)

    def announce(self, kind: NewsKind, key: str) -> None:
        """Tell the other processes of the cloud that this one has changed a record, now or once there is a master."""
        if not self._master.tell(MasterCalls.announce, kind, key):
            self._untold.append((kind, key))

    def master_found(self) -> None:
        """Send the limits of users, and the changes of records that no master got, to a new master."""
        for user, limits in self._limits.items():
            self._master.tell(MasterCalls.set_limits, user, limits)
        untold, self._untold = [*self._untold], deque(maxlen=MAX_UNTOLD)
        for kind, key in untold:
            self.announce(kind, key)

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the other processes of the cloud know of a robot, as JSON; nothing without a master."""
        try:
            return await self._master.call(MasterCalls.facts, kind, user, robot)
        except Unavailable:
            return []

    def map_changed(self, head: MapRecord) -> None:
        """Let the robots on a map, or with it as a mask, go on with its current version."""
        self._master.tell(MasterCalls.map_changed, head)

    # -- robots --------------------------------------------------------------------------------------------------------

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected; None for all while no master answers."""
        if self._master.is_up:
            with suppress(Unavailable):
                return await self._master.call(CloudCalls.connected, robots)
        return [None] * len(robots)

    async def robot_state(self, user: str, robot: str) -> RobotState:
        """Return the pose and the active goals of a robot, connected or not."""
        return await self._master.call(CloudCalls.robot_state, user, robot)

    async def send_goal(self, user: str, robot: str, pose: Pose2D) -> GoalView:
        """Send a robot to a pose in the frame ``map``."""
        return await self._master.call(CloudCalls.send_goal, user, robot, pose)

    async def goals(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals that REST sent to a robot since it last connected, oldest first."""
        return await self._master.call(CloudCalls.goals, user, robot)

    async def goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Return a goal."""
        return await self._master.call(CloudCalls.goal, user, robot, goal_id)

    async def cancel_goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal."""
        return await self._master.call(CloudCalls.cancel_goal, user, robot, goal_id)

    async def cancel_goals(self, user: str, robot: str) -> None:
        """Cancel all goals of a robot, also those of other clients."""
        await self._master.call(CloudCalls.cancel_goals, user, robot)

    # -- nodes of robots -----------------------------------------------------------------------------------------------

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

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        """Send a page of a joint map to a robot that makes a map."""
        return await self._nodes.use_joint_map(user, robot, page)

    async def robot_octomap(self, user: str, robot: str, request: GetOctomapFileRequest) -> GetOctomapFileResponse:
        """Return a page of the octomap that a robot makes; an empty one if it makes none."""
        return await self._nodes.octomap(user, robot, request)

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots that make new maps now, except those that continue a published one."""
        return await self._master.call(CloudCalls.mapping_robots)

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots that continue a published map for life now."""
        return await self._master.call(CloudCalls.lifelong_robots)

    # -- people --------------------------------------------------------------------------------------------------------

    async def people_groups(self) -> list[PeopleGroupView]:
        """Return the groups of robots that track people now, and the states of their coordinators."""
        return await self._master.call(CloudCalls.people_groups)

    async def people(self, user: str, map: str) -> PeopleState:  # noqa: A002
        """Return the people whom the robots of a user see on a map."""
        return await self._master.call(CloudCalls.people, user, map)

    async def people_counts(self, user: str, map: str, since: int) -> list[ZoneCount]:  # noqa: A002
        """Return the numbers of different people by hour and zone, without hours that ended before a time."""
        return await self._master.call(CloudCalls.people_counts, user, map, since)

    async def configure_people(self, user: str, map: str, settings: PeopleSettings) -> None:  # noqa: A002
        """Make the coordinator of a user's robots on a map use settings, which are stored already."""
        await self._master.call(CloudCalls.configure_people, user, map, settings)

    async def end_groups(self, map: str) -> None:  # noqa: A002
        """End the people coordinators and traffic nodes of a map that no robot uses and that is removed."""
        await self._master.call(CloudCalls.end_groups, map)

    # -- traffic -------------------------------------------------------------------------------------------------------

    async def traffic(self, user: str, map: str) -> TrafficState:  # noqa: A002
        """Return the traffic of the robots of a user on a map."""
        return await self._master.call(CloudCalls.traffic, user, map)

    async def take_out(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        """Take a robot of a user out of the traffic of a map."""
        await self._master.call(CloudCalls.take_out, user, map, robot)

    async def put_back(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        """Put a robot of a user back into the traffic of a map."""
        await self._master.call(CloudCalls.put_back, user, map, robot)

    # -- tasks ---------------------------------------------------------------------------------------------------------

    async def tasks_changed(self, user: str, map: str) -> None:  # noqa: A002
        """Let the master read the tasks of a user on a map again."""
        await self._master.call(CloudCalls.tasks_changed, user, map)

    # -- paths ---------------------------------------------------------------------------------------------------------

    async def compute_path(self, user: User, map: MapVersion, request: PathRequest) -> PathAnswer:  # noqa: A002
        """Compute a path in a planning container."""
        return await self._planning.compute_path(user.id, map, request)

    async def compute_costs(self, user: User, map: MapVersion, request: CostRequest) -> CostAnswer:  # noqa: A002
        """Compute the costs from each start to each goal in a planning container."""
        return await self._planning.compute_costs(user.id, map, request)

    async def plan_fleet(self, user: User, map: MapVersion, request: FleetRequest) -> FleetAnswer:  # noqa: A002
        """Plan for a fleet in a planning container."""
        return await self._planning.plan_fleet(user.id, map, request)
