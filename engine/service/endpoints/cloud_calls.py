"""Calls of the master that every process of a cloud makes in the same way."""

from typing import Protocol

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
from engine.specs.machine_settings import MachineSettings
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import TrafficState
from ppaas.messages.people_coordination import PeopleState, ZoneCount
from ppaas.people.settings import PeopleSettings


class CloudCalls(Protocol):
    """Methods of the master that do not depend on the endpoint; part of what endpoints offer to their requests."""

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        ...

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
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

    async def admit_machine(self, machine: str) -> None:
        """Allow a removed machine to join again."""
        ...

    async def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all containers with None."""
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

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected; None for those of which it is not known."""
        ...

    async def robot_state(self, user: str, robot: str) -> RobotState:
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
        """Cancel all goals of a robot, also those of other clients; ``Unavailable`` if it is not connected."""
        ...

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots that make new maps now, except those that continue a published one."""
        ...

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots that continue a published map for life now."""
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

    async def traffic(self, user: str, map: str) -> TrafficState:  # noqa: A002
        """Return the traffic of the robots of a user on a map.

        Raises
        ------
        Unavailable
            No robot of the user takes part in the traffic of the map, or its traffic node does not answer.
        """
        ...

    async def take_out(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        """Take a robot of a user out of the traffic of a map: what it holds is free, and nobody waits for it.

        Raises
        ------
        NotFound
            The traffic node knows no such robot.
        Unavailable
            As ``traffic``.
        """
        ...

    async def put_back(self, user: str, map: str, robot: str) -> None:  # noqa: A002
        """Put a robot of a user back into the traffic of a map, where it now stands.

        Raises
        ------
        NotFound
            The traffic node knows no such robot.
        Unavailable
            As ``traffic``.
        """
        ...

    async def tasks_changed(self, user: str, map: str) -> None:  # noqa: A002
        """Let the tasks of a user on a map be read again, since one was added or cancelled.

        Raises
        ------
        Unavailable
            The master does not answer. It reads them later by itself.
        """
        ...

    async def end_groups(self, map: str) -> None:  # noqa: A002
        """End the people coordinators and traffic nodes of a map that no robot uses and that is removed.

        They outlive their robots for a while, and would store their checkpoints again.
        """
        ...
