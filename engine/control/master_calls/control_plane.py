"""The engine, as endpoints and the jobs of the master use it: one Protocol a subject."""

from collections.abc import Awaitable, Callable, Sequence
from typing import Protocol

from engine.calls.interface import notice
from engine.control.news import FactKind, NewsKind
from engine.control.planning.planning import Planning
from engine.control.robot_nodes import RobotNodes
from engine.control.robot_stops import StopCalls
from engine.control.views import (
    ContainerView,
    EndpointView,
    GoalView,
    LifelongRobot,
    MachineView,
    MappingRobot,
    NavigationState,
    PeopleGroupView,
    ReportedRobot,
    UserUsage,
)
from engine.master.quotas import Quotas
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import StartState
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.people.settings import PeopleSettings
from storage.records import Limits, MapRecord


class PeopleCalls(Protocol):
    """People whom robots see."""

    async def views(self) -> list[PeopleGroupView]:
        """Return the groups of robots that track people now, and the states of their coordinators."""
        ...

    async def people(self, user: str, map_id: str) -> PeopleState:
        """Return the people whom the robots of a user see on a map.

        Raises
        ------
        Unavailable
            No robot of the user tracks people on the map, or their coordinator was refused or does not answer.
        """
        ...

    async def counts(self, user: str, map_id: str, since: int) -> list[ZoneCount]:
        """Return the numbers of different people by hour and zone, without hours that ended before a time.

        Raises
        ------
        Unavailable
            As ``people``.
        """
        ...

    async def configure(self, user: str, map_id: str, settings: PeopleSettings) -> None:
        """Make the coordinator of a user's robots on a map, if there is one, use settings that are stored already.

        Raises
        ------
        InvalidInput, NotFound
            The coordinator refuses the settings; NotFound if it has no rule of that name.
        Unavailable
            The coordinator does not answer.
        """
        ...


class TrafficCalls(Protocol):
    """Traffic of robots that drive by grants."""

    async def state(self, user: str, map_id: str) -> TrafficState:
        """Return the traffic of the robots of a user on a map.

        Raises
        ------
        Unavailable
            No robot of the user takes part in the traffic of the map, or its traffic node was refused or does not
            answer.
        """
        ...

    async def take_out(self, user: str, map_id: str, robot: str) -> None:
        """Take a robot of a user out of the traffic of a map: what it holds is free, and nobody waits for it.

        Raises
        ------
        NotFound
            The traffic node knows no such robot.
        Unavailable
            As ``state``.
        """
        ...

    async def put_back(self, user: str, map_id: str, robot: str) -> None:
        """Put a robot of a user back into the traffic of a map, where it now stands.

        Raises
        ------
        NotFound
            The traffic node knows no such robot.
        Unavailable
            As ``state``.
        """
        ...


class TaskCalls(Protocol):
    """Tasks of robots."""

    async def changed(self, user: str, map_id: str) -> None:
        """Read the tasks of a user on a map again, since one was added or cancelled.

        Raises
        ------
        Unavailable
            The master does not answer. It reads them later by itself.
        """
        ...


class MachineCalls(Protocol):
    """Machines of the cloud."""

    async def views(self) -> list[MachineView]:
        """Return all machines, and those that are about to join."""
        ...

    async def settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine.

        Raises
        ------
        NotFound
            The machine does not exist.
        Starting
            It has not joined yet.
        """
        ...

    async def configure(self, machine: str, settings: MachineSettings) -> None:
        """Apply and store settings of a machine.

        Raises
        ------
        InvalidParameter
            The settings are invalid.
        NotFound, Starting
            As ``settings``.
        Unavailable
            The settings are in effect, but could not be stored.
        """
        ...

    async def remove(self, machine: str, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted.

        Raises
        ------
        Conflict
            It runs containers and ``force`` is false.
        NotFound, Starting
            As ``settings``.
        Unavailable
            The machine is removed, but this could not be stored.
        """
        ...

    async def admit(self, machine: str) -> None:
        """Accept a removed machine again; its agent must be started on the machine itself."""
        ...


class ContainerCalls(Protocol):
    """Containers that run on machines."""

    async def views(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all containers with None."""
        ...

    async def give_up(self, container: str) -> None:
        """End a container as if it had died: its place gets another one, and clients notice only a pause.

        Raises
        ------
        NotFound
            The container does not exist or has ended.
        Unavailable
            Its machine is disconnected.
        """
        ...

    async def resize(self, container: str, cores: float) -> None:
        """Resize a running container [cores]; its place keeps the size while it is open.

        Raises
        ------
        NotFound
            The container does not exist or has ended.
        InvalidParameter
            The size is invalid.
        QuotaExceeded
            The size exceeds the quota of its user.
        Unavailable
            Its machine has no capacity for this size now.
        """
        ...


class NeighbourCalls(Protocol):
    """Endpoints of the cloud."""

    async def views(self) -> list[EndpointView]:
        """Return all endpoints that are connected to the master."""
        ...


class MapCalls(Protocol):
    """Maps that robots drive on or make."""

    @notice
    async def changed(self, head: MapRecord) -> None:
        """Move the robots that drive on a map, or have it as a mask, to its current version.

        Every change of the current version must be followed by it.
        """
        ...

    async def end_groups(self, map_id: str) -> None:
        """End the people coordinators and traffic nodes of a map that no robot uses and that is removed.

        They outlive their robots for a while, and would store their checkpoints again.
        """
        ...

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots that make new maps now, except those that continue a published one."""
        ...

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots that continue a published map for life now."""
        ...


class RobotCalls(Protocol):
    """Robots of all users."""

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots are connected; called by endpoints of protocol 1 alone."""
        ...

    async def views(self, robots: list[tuple[str, str]]) -> list[ReportedRobot]:
        """Return the states of some robots, by user and id, as their containers reported them last."""
        ...

    async def state(self, user: str, robot: str) -> NavigationState:
        """Return the pose and the active goals of a robot, connected or not."""
        ...

    async def send_goal(self, user: str, robot: str, pose: Pose2D) -> GoalView:
        """Send a robot to a pose in the frame ``map``.

        Raises
        ------
        Unavailable
            The robot is not connected, whether or not its container still waits for it.
        QuotaExceeded
            The robot has too many active goals.
        """
        ...

    async def goals(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals that REST sent to a robot since it last connected, oldest first."""
        ...

    async def goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Return a goal; ``NotFound`` if it is unknown or forgotten."""
        ...

    async def cancel_goal(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal.

        Raises
        ------
        NotFound
            It is unknown or forgotten.
        Conflict
            It has ended.
        Unavailable
            The robot is not connected.
        """
        ...

    async def cancel_goals(self, user: str, robot: str) -> None:
        """Cancel all goals of a robot, also goals of other clients; ``Unavailable`` if it is not connected."""
        ...


class MoveCalls(Protocol):
    """Robots that are moved to other maps."""

    async def moved(self, user: str, robot: str) -> None:
        """Let the clone of a robot go on with the map and the initial pose in its file, which were changed.

        It keeps its session, and its container is replaced in the room that it has.

        Raises
        ------
        NotFound, NotPermitted, InvalidMap, InvalidParameter
            The map cannot be used.
        """
        ...


class UserCalls(Protocol):
    """Places and quotas of users."""

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        ...

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        ...

    async def take_paths(self, user: str, paths: int, ahead: int) -> int:
        """Count paths that a user requests, and up to ``ahead`` further ones; return the number of these.

        Raises
        ------
        QuotaExceeded
            They exceed the quota; see ``PlanRate.take``.
        """
        ...

    async def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored; opens the queued places that they allow."""
        ...

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or only the place of a robot, and notify their clients of the reason."""
        ...


CountPaths = Callable[[str, int], Awaitable[object]]
"""Counts paths that a user requests; raises ``QuotaExceeded``."""


class MasterParts(Protocol):
    """Parts of the master that every process of a cloud calls in the same way, by subject.

    In the process of the master they are the parts themselves, elsewhere each call is one over the link to the master.
    """

    robots: RobotCalls
    moves: MoveCalls
    maps: MapCalls
    people: PeopleCalls
    traffic: TrafficCalls
    tasks: TaskCalls
    machines: MachineCalls
    containers: ContainerCalls
    endpoints: NeighbourCalls
    users: UserCalls
    stops: StopCalls


class ControlPlane(MasterParts, Protocol):
    """The engine: the parts of the master, and what each process of a cloud does in its own way.

    Attributes
    ----------
    nodes : RobotNodes
        Calls the clones of robots.
    planning : Planning
        Plans in planning containers.
    quotas : Quotas
        Limits of the users.
    count_paths : callable
        Counts paths that a user requests; raises ``QuotaExceeded``.
    """

    nodes: RobotNodes
    planning: Planning
    quotas: Quotas
    count_paths: CountPaths

    @property
    def master_silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has, and 0 in the process of the master."""
        ...

    @property
    def start(self) -> StartState:
        """Whether containers can start, and the kernels that machines compile."""
        ...

    async def robot_views(self, robots: list[tuple[str, str]]) -> Sequence[ReportedRobot | None]:
        """Return the states of some robots, by user and id; None for all while no master answers."""
        ...

    async def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored, without waiting for the master.

        Every request of a user begins with it, since another process may have changed the limits.
        """
        ...

    def announce(self, kind: NewsKind, key: str) -> None:
        """Notify the other processes of the cloud that this one has changed a record, so that their caches drop it."""
        ...

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the other processes of the cloud know of a robot, as JSON; nothing while no master answers."""
        ...
