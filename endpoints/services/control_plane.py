"""Interface of the engine to the endpoints."""

from typing import Protocol

from engine.master.quotas import Quotas
from engine.service.endpoints.cloud_calls import CloudCalls
from engine.service.news.news import NewsKind
from engine.service.news.robot_facts import FactKind
from engine.service.planning.fleet_requests import FleetAnswer, FleetRequest
from engine.service.planning.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.specs.containers import MapVersion
from engine.specs.start_state import StartState
from ppaas.diagnosis.observations.facts import Observations
from ppaas.errors import PPaaSError
from ppaas.messages.base.message import Message
from ppaas.messages.health.recorder import RecorderState
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse
from storage.records import Limits, MapRecord, User


class ControlPlane(CloudCalls, Protocol):
    """The engine, as the endpoints use it."""

    @property
    def quotas(self) -> Quotas:
        """Limits of the users."""
        ...

    @property
    def master_silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has, and 0 in the process of the master."""
        ...

    @property
    def start(self) -> StartState:
        """Whether containers can start, and the kernels that machines compile."""
        ...

    async def count_paths(self, user: str, paths: int) -> None:
        """Count paths that a user requests.

        Raises
        ------
        QuotaExceeded
            They exceed the quota; see ``PlanRate.take``.
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

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or that of a robot, and notify their clients of the reason."""
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

    async def plan_fleet(self, user: User, map: MapVersion, request: FleetRequest) -> FleetAnswer:  # noqa: A002
        """Plan for a fleet in a container of the user.

        Raises
        ------
        InvalidInput
            There are too many robots or cells, a number is out of range, or two robots share a cell.
        PlanningError, QuotaExceeded, Unavailable
            As ``compute_path``.
        """
        ...
