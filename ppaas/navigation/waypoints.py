"""List of waypoints, and a robot's progress along it."""

import msgspec

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.navigation.events import Goal

MAX_WAYPOINTS = 1000
"""Largest number of waypoints in a list, which is part of every checkpoint until it is done."""

MAX_LOOPS = 2**32 - 1


class Missed(msgspec.Struct, frozen=True):
    """A missed waypoint, with the reason in the latest loop."""

    index: int
    reason: str


class Waypoints(msgspec.Struct):
    """Active list of waypoints; checkpoints contain it as JSON.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    poses : list of Pose2D
        In the map frame.
    number_of_loops : int
        Number of times to start over after the last waypoint.
    index : int
        Index of the waypoint that the robot drives to, or has just reached; initially the first one.
    loop : int
        Number of times the list was started over.
    reached : bool
        Whether any waypoint of this loop was reached.
    pausing : bool
        Whether the robot stands at the waypoint.
    missed : list of Missed
        Missed waypoints, each once.
    """

    id: str
    stamp: float
    poses: list[Pose2D]
    number_of_loops: int = 0
    index: int = 0
    loop: int = 0
    reached: bool = False
    pausing: bool = False
    missed: list[Missed] = msgspec.field(default_factory=list)

    @property
    def goal(self) -> Goal:
        """The waypoint as a goal of Move Base; its id is unique in every loop."""
        return Goal(f"{self.id}/{self.loop}/{self.index}", self.poses[self.index], self.stamp)

    def reach(self) -> None:
        """Record that the waypoint was reached."""
        self.reached = True
        self.missed = [missed for missed in self.missed if missed.index != self.index]

    def miss(self, reason: str) -> None:
        """Record that the waypoint was missed."""
        kept = [missed for missed in self.missed if missed.index != self.index]
        self.missed = [*kept, Missed(self.index, reason)]

    def go_on(self) -> bool:
        """Advance to the next waypoint; return whether there is one."""
        self.pausing = False
        if self.index + 1 < len(self.poses):
            self.index += 1
            return True
        # If every waypoint of a loop was missed, further loops would fail too, as fast as plans fail.
        if self.loop >= self.number_of_loops or not self.reached:
            return False
        self.index, self.reached = 0, False
        self.loop += 1
        return True


def check(count: int, number_of_loops: int, goal_index: int) -> None:
    """Check the numbers of a list before it is taken.

    Raises
    ------
    InvalidInput
        The list is empty or too long, or a number is out of range.
    """
    if not 0 < count <= MAX_WAYPOINTS:
        raise InvalidInput(f"poses must have from 1 to {MAX_WAYPOINTS} waypoints, not {count}")
    if not 0 <= number_of_loops <= MAX_LOOPS:
        raise InvalidInput(f"number_of_loops must be from 0 to {MAX_LOOPS}, not {number_of_loops}")
    if not 0 <= goal_index < count:
        raise InvalidInput(f"goal_index must be from 0 to {count - 1}, the last waypoint, not {goal_index}")
