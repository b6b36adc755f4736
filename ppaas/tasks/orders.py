"""Robots as a dispatcher of tasks sees them, and its orders."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ppaas.energy.battery import Battery
from ppaas.tasks.records import GOALS, Place, Task

Outcome = Literal["succeeded", "canceled", "aborted", "rejected", "lost"]
"""How a goal of Move Base ended; ``lost``: the robot's clone does not know it any more."""


@dataclass(frozen=True, slots=True)
class RobotNow:
    """A connected robot.

    Parameters
    ----------
    place : Place, optional
        Where it is; None while it does not know.
    labels : mapping of str to str
    goals : frozenset of str
        Ids of the goals that its Move Base follows or has waiting, no matter who sent them.
    battery : Battery, optional
        Its battery; None if it does not report it.
    """

    place: Place | None
    labels: Mapping[str, str] = field(default_factory=dict)
    goals: frozenset[str] = frozenset()
    battery: Battery | None = None

    @property
    def is_led(self) -> bool:
        """Return whether somebody else sends it to goals."""
        return any(not goal.startswith(GOALS) for goal in self.goals)


@dataclass(frozen=True, slots=True)
class StoreTask:
    """Store a task, in place of the record with the same id; before the orders that follow."""

    task: Task


@dataclass(frozen=True, slots=True)
class Send:
    """Send a robot to a place. A goal whose id its Move Base knows is the same goal, sent again.

    Parameters
    ----------
    robot, goal_id : str
    place : Place
        Where to, with its floor.
    over_floors : bool
        Whether the task names floors, so that lifts and doors are taken on the way.
    """

    robot: str
    goal_id: str
    place: Place
    over_floors: bool = False


@dataclass(frozen=True, slots=True)
class Cancel:
    """Cancel a goal of a robot, if it has it."""

    robot: str
    goal_id: str


Order = StoreTask | Send | Cancel
