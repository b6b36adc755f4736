"""Interface of the engine to the endpoints."""

from typing import Protocol

from engine.master.quotas import Quotas
from engine.service.news.news import NewsKind
from engine.service.news.robot_facts import FactKind
from engine.service.planning.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
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
from ppaas.diagnosis.observations.facts import Observations
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.health.recorder import RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse
from ppaas.people.settings import PeopleSettings
from storage.records import Limits, MapRecord, User


class ControlPlane(Protocol):
    """The engine, as the endpoints use it."""

    @property
    def quotas(self) -> Quotas:
        """Limits of the users."""
        ...

    @property
    def master_silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has, and 0 in the process of the master."""
        ...

    async def count_paths(self, user: str, paths: int) -> None:
        """Count paths that a user requests.

        Raises
        ------
        QuotaExceeded
            They exceed the quota; see ``PlanRate.take``.
        """
        ...

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        ...

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        ...

    async def robot_state(self, user: str, robot: str) -> RobotState:
        """Return the pose and the active goals of a robot, connected or not."""
        ...

    async def send_goal(self, user: str, robot: str, pose: Pose2D) -> GoalView:
        """Send a robot to a pose in the frame ``map``.

        Raises
        ------
        Unavailable
            The robot is not connected.
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
        """Cancel all goals of a robot, also those of other clients; ``Unavailable`` if it is not connected."""
        ...

    async def machines(self) -> list[MachineView]:
        """Return all machines."""
        ...

    async def endpoints(self) -> list[EndpointView]:
        """Return all endpoints that are connected to the master."""
        ...

    async def machine_settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine; ``NotFound`` if it does not exist."""
        ...

    async def configure_machine(self, machine: str, settings: MachineSettings) -> None:
        """Change the settings of a machine.

        Raises
        ------
        InvalidParameter
            The settings are invalid.
        NotFound
            The machine does not exist.
        """
        ...

    async def remove_machine(self, machine: str, *, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted.

        Raises
        ------
        Conflict
            It runs containers and ``force`` is false.
        NotFound
            The machine does not exist.
        """
        ...

    async def admit_machine(self, machine: str) -> None:
        """Allow a removed machine to join again."""
        ...

    async def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all containers with None."""
        ...

    async def end_places(self, user: str, reason: PPaaSError) -> None:
        """Close all places of a user, and notify their clients of the reason."""
        ...

    async def give_up_container(self, container: str) -> None:
        """End a container as if it had died; its place gets another one.

        Raises
        ------
        NotFound
            The container does not exist or has ended.
        Unavailable
            Its machine is disconnected.
        """
        ...

    def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored; starts the waiting places that they allow.

        Every request of a user begins with it, since another process may have changed the limits.
        """
        ...

    def announce(self, kind: NewsKind, key: str) -> None:
        """Tell the other processes of the cloud that this one has changed a record, so that their caches drop it."""
        ...

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the other processes of the cloud know of a robot, as JSON."""
        ...

    def map_changed(self, head: MapRecord) -> None:
        """Let the robots that drive on a map, or have it as a mask, go on with its current version.

        Every change of the current version must be followed by it.
        """
        ...

    async def resize_container(self, container: str, cores: float) -> None:
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

    async def node_homes(self, user: str, robot: str) -> list[NodeHome]:
        """Return the home of each node of a robot, with reasons; ``Unavailable`` if the robot has no container."""
        ...

    async def run_node(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        """Move a node to a home; with an empty ``home``, let the node monitor choose.

        Raises
        ------
        NotFound
            The robot has no such node.
        Unavailable
            The robot has no container.
        """
        ...

    async def observe_robot(self, user: str, robot: str, seconds: float) -> Observations:
        """Return what is observed of a robot, once its clone has watched it for a time [s].

        Raises
        ------
        Unavailable
            The robot has no container now.
        """
        ...

    async def call_recorder(self, user: str, robot: str, service: str, request: Message) -> RecorderState:
        """Call a service of the recorder of a robot, ``start``, ``stop`` or ``state``; return its state.

        Raises
        ------
        Conflict
            A recording is in progress.
        InvalidParameter
            The time or the topics are invalid.
        Unavailable
            The robot has no container now.
        """
        ...

    async def robot_map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        """Return a page of the pose graph of the map that a robot makes, from an offset [bytes]; −1: its numbers.

        Raises
        ------
        Unavailable
            The robot has no container now, or no map yet.
        Conflict
            The robot does not make a map.
        """
        ...

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots that make new maps now, except those that continue a published one."""
        ...

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots that continue a published map for life now."""
        ...

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        """Send a page of a joint map to a robot that makes a map; after the last one it goes on with the joint map.

        Raises
        ------
        Unavailable
            The robot has no container or no map now.
        Conflict
            The joint map does not contain the robot's own map.
        """
        ...

    async def people_groups(self) -> list[PeopleGroupView]:
        """Return the groups of robots that track people now, and the states of their coordinators."""
        ...

    async def people(self, user: str, map: str) -> PeopleState:  # noqa: A002
        """Return the people whom the robots of a user see on a map.

        Raises
        ------
        Unavailable
            No robot of the user tracks people on the map, or their coordinator does not answer.
        """
        ...

    async def people_counts(self, user: str, map: str, since: int) -> list[ZoneCount]:  # noqa: A002
        """Return the numbers of different people by hour and zone, without hours that ended before a time.

        Raises
        ------
        Unavailable
            As ``people``.
        """
        ...

    async def configure_people(self, user: str, map: str, settings: PeopleSettings) -> None:  # noqa: A002
        """Make the coordinator of a user's robots on a map, if there is one, use settings that are stored already.

        Raises
        ------
        InvalidInput, NotFound
            The coordinator refuses the settings; NotFound if it has no rule of that name.
        Unavailable
            The coordinator does not answer.
        """
        ...

    async def end_people(self, map: str) -> None:  # noqa: A002
        """End the people coordinators of a map that no robot uses and that is removed.

        A coordinator outlives its robots for a while, and would store its checkpoint again.
        """
        ...

    async def robot_octomap(self, user: str, robot: str, request: GetOctomapFileRequest) -> GetOctomapFileResponse:
        """Return a page of the octomap that a robot makes; an empty one if it makes none.

        Raises
        ------
        Unavailable
            The robot has no container now.
        """
        ...

    async def compute_path(self, user: User, map: MapVersion, request: PathRequest) -> PathAnswer:  # noqa: A002
        """Plan a path in a container of the user.

        The caller must have checked that the user may read the map.

        Raises
        ------
        PlanningError
            There is no path; one of its subclasses.
        Queued
            The request waits in the queue, as it allowed.
        QuotaExceeded
            The user may not have another container.
        Unavailable
            No machine has capacity, or the container was lost.
        """
        ...

    async def compute_costs(self, user: User, map: MapVersion, request: CostRequest) -> CostAnswer:  # noqa: A002
        """Compute the costs from each start to each goal in a container of the user.

        Raises
        ------
        InvalidInput
            There are too many starts or goals.
        PlanningError, QuotaExceeded, Unavailable
            As ``compute_path``.
        """
        ...
