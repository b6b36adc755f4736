"""A list of waypoints, and how far a robot is with it."""

import msgspec

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.navigation.events import Goal

MAX_WAYPOINTS = 1000
"""Most waypoints of a list: it is part of every checkpoint until it is done."""

MAX_LOOPS = 2**32 - 1


class Missed(msgspec.Struct, frozen=True):
    """Why a waypoint was missed, the last time round."""

    index: int
    reason: str


class Waypoints(msgspec.Struct):
    """A list of waypoints under way; as JSON it is what a checkpoint keeps of it.

    Parameters
    ----------
    id, stamp
        Of the goal, as of any action's.
    poses : list of Pose2D
        In the map frame.
    number_of_loops : int
        How often to begin again after the last waypoint.
    index : int
        Of the waypoint that the robot drives to, or has just reached; at first the one to begin with.
    loop : int
        How often it has begun again.
    reached : bool
        Whether any waypoint of this loop was reached.
    pausing : bool
        Whether it stands at the waypoint.
    missed : list of Missed
        Each waypoint once.
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
        """The waypoint as a goal of Move Base; its id is its own, also the next time round."""
        return Goal(f"{self.id}/{self.loop}/{self.index}", self.poses[self.index], self.stamp)

    def reach(self) -> None:
        """Take note that the waypoint was reached."""
        self.reached = True
        self.missed = [missed for missed in self.missed if missed.index != self.index]

    def miss(self, reason: str) -> None:
        """Take note that the waypoint was missed."""
        kept = [missed for missed in self.missed if missed.index != self.index]
        self.missed = [*kept, Missed(self.index, reason)]

    def go_on(self) -> bool:
        """Turn to the next waypoint; tell whether there is one."""
        self.pausing = False
        if self.index + 1 < len(self.poses):
            self.index += 1
            return True
        # Who missed every waypoint of a loop would miss them for ever, as fast as plans fail.
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
        There is no waypoint, or there are too many; or a number is out of range.
    """
    if not 0 < count <= MAX_WAYPOINTS:
        raise InvalidInput(f"a list has from 1 to {MAX_WAYPOINTS} waypoints, not {count}; send poses")
    if not 0 <= number_of_loops <= MAX_LOOPS:
        raise InvalidInput(f"number_of_loops must be from 0 to {MAX_LOOPS}, not {number_of_loops}")
    if not 0 <= goal_index < count:
        raise InvalidInput(f"goal_index must be from 0 to {count - 1}, the last of the list, not {goal_index}")
