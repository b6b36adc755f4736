"""Calls of the master about robots: where they are, and the goals that REST sends them to."""

from typing import Protocol

from engine.service.views import GoalView, RobotState
from ppaas.geometry import Pose2D


class RobotCalls(Protocol):
    """Robots of all users."""

    async def connected(self, robots: list[tuple[str, str]]) -> list[bool | None]:
        """Return which of some robots, by user and id, are connected; None where it is not known."""
        ...

    async def state(self, user: str, robot: str) -> RobotState:
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
