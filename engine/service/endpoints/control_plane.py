"""The engine, as endpoints and the jobs of the master use it."""

from collections.abc import Awaitable, Callable
from typing import Protocol

from engine.master.quotas import Quotas
from engine.service.endpoints.group_calls import PeopleCalls, TaskCalls, TrafficCalls
from engine.service.endpoints.machine_calls import ContainerCalls, MachineCalls, NeighbourCalls
from engine.service.endpoints.map_calls import MapCalls
from engine.service.endpoints.robot_calls import RobotCalls
from engine.service.endpoints.user_calls import UserCalls
from engine.service.news.news import NewsKind
from engine.service.news.robot_facts import FactKind
from engine.service.planning.planning import Planning
from engine.service.robot_nodes import RobotNodes
from engine.specs.start_state import StartState
from storage.records import Limits

CountPaths = Callable[[str, int], Awaitable[object]]
"""Counts paths that a user requests; raises ``QuotaExceeded``."""


class MasterParts(Protocol):
    """Parts of the master that every process of a cloud calls in the same way, by subject.

    In the process of the master they are the parts themselves, elsewhere each call is one over the link to the master.
    """

    robots: RobotCalls
    maps: MapCalls
    people: PeopleCalls
    traffic: TrafficCalls
    tasks: TaskCalls
    machines: MachineCalls
    containers: ContainerCalls
    endpoints: NeighbourCalls
    users: UserCalls


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

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected; None for all while no master answers."""
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
