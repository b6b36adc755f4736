"""Outcomes of a drive: the messages of its clone, and the differences between the clones of two drives, in words."""

import math
from bisect import bisect_left
from dataclasses import dataclass, field
from statistics import median
from typing import NamedTuple

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.nodes import topics

COMPARED = frozenset(
    topic.name for topic in (topics.AMCL_POSE, topics.SLAM_POSE, topics.CMD_VEL, topics.MOVE_BASE_RESULT)
)
"""Topics that are compared."""

NEAR = 0.15
"""Largest time between two velocities that are compared [s]."""

MOST = 1_000_000
"""Largest number of messages of a topic that are compared."""

NO_END = "no end"
"""End of a goal without a result."""

FAR, FAR_TURNED = 0.3, 0.3
"""Distance and angle of two poses of the same scan from which the drives differ [m, rad]."""


class TimedVelocity(NamedTuple):
    """Command, and the time since the begin of the drive [s]; speeds in m/s and rad/s."""

    at: float
    linear: float
    angular: float


@dataclass(slots=True)
class Outcomes:
    """Messages of a clone.

    Attributes
    ----------
    poses : dict of int to Pose2D
        Estimates by the stamp of their scan [ns].
    velocities : list of TimedVelocity
    results : dict of str to Status
        Results by goal.
    """

    poses: dict[int, Pose2D] = field(default_factory=dict)
    velocities: list[TimedVelocity] = field(default_factory=list)
    results: dict[str, Status] = field(default_factory=dict)

    def take(self, topic: str, message: Message, at: float) -> None:
        """Note a message of a topic of `COMPARED` at a time since the begin [s]."""
        match message:
            case PoseWithCovarianceStamped() if len(self.poses) < MOST and not (
                topic == topics.SLAM_POSE.name and self.poses
            ):
                stamp = message.header.stamp
                self.poses[stamp.secs * 10**9 + stamp.nsecs] = message.pose.pose.planar()
            case Twist() if len(self.velocities) < MOST:
                self.velocities.append(TimedVelocity(at, message.linear.x, message.angular.z))
            case MoveBaseActionResult() if len(self.results) < MOST:
                self.results[message.status.goal_id.id] = Status(message.status.status)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Differences between a drive and its replay.

    Parameters
    ----------
    poses : int
        Number of scans for which both estimated a pose.
    median_distance, most_distance : float
        Between the two poses of a scan [m].
    most_turned : float
        Largest angle between them [rad].
    velocities : int
        Number of commands that both sent at about the same time.
    linear, angular : float
        Mean absolute difference of their speeds [m/s, rad/s].
    goals : dict of str to (str, str)
        How each goal ended in the drive and in the replay; `NO_END` if it did not.
    """

    poses: int = 0
    median_distance: float = 0.0
    most_distance: float = 0.0
    most_turned: float = 0.0
    velocities: int = 0
    linear: float = 0.0
    angular: float = 0.0
    goals: dict[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def differs(self) -> bool:
        """True if a goal ended otherwise, or poses are far from each other."""
        return (
            any(first != second for first, second in self.goals.values())
            or self.most_distance > FAR
            or self.most_turned > FAR_TURNED
        )

    def words(self) -> list[str]:
        """Return sentences."""
        found = []
        if self.poses:
            found.append(
                f"{self.poses} scans were localized in both: poses are {self.median_distance:.3f} m apart (median), "
                f"at most {self.most_distance:.3f} m and {math.degrees(self.most_turned):.1f}°."
            )
        else:
            found.append("No pose can be compared: there is no scan that both localized.")
        if self.velocities:
            found.append(
                f"{self.velocities} commands were compared: speeds differ by {self.linear:.3f} m/s and "
                f"{self.angular:.3f} rad/s (mean)."
            )
        for goal, (first, second) in self.goals.items():
            same = "as recorded" if first == second else f"but was recorded as {first}"
            found.append(f"Goal {goal!r} ended with {second}, {same}.")
        return found


def compare(recorded: Outcomes, replayed: Outcomes) -> Comparison:
    """Return the differences between a recorded drive and its replay; goals of the replay alone are left out."""
    both = [(pose, replayed.poses[stamp]) for stamp, pose in recorded.poses.items() if stamp in replayed.poses]
    distances = [one.distance_to(other) for one, other in both]
    turned = [abs(math.remainder(one.theta - other.theta, math.tau)) for one, other in both]
    pairs = _pairs(recorded.velocities, replayed.velocities)
    return Comparison(
        poses=len(both),
        median_distance=median(distances) if both else 0.0,
        most_distance=max(distances, default=0.0),
        most_turned=max(turned, default=0.0),
        velocities=len(pairs),
        linear=_mean([abs(one.linear - other.linear) for one, other in pairs]),
        angular=_mean([abs(one.angular - other.angular) for one, other in pairs]),
        goals=_ends(recorded, replayed),
    )


def _ends(recorded: Outcomes, replayed: Outcomes) -> dict[str, tuple[str, str]]:
    """Return how each recorded goal ended in both drives.

    A goal without an id got one of the clone, which is another in the replay: such goals are matched by their order.
    """
    others = iter([end for goal, end in replayed.results.items() if goal not in recorded.results])
    found = {}
    for goal, status in recorded.results.items():
        end = replayed.results[goal] if goal in replayed.results else next(others, None)
        found[goal] = status.name, NO_END if end is None else end.name
    return found


def _pairs(first: list[TimedVelocity], second: list[TimedVelocity]) -> list[tuple[TimedVelocity, TimedVelocity]]:
    """Return each command of the first drive with the nearest in time of the second, if that is near."""
    times = [one.at for one in second]
    pairs = []
    for one in first:
        place = bisect_left(times, one.at)
        near = min(second[max(place - 1, 0) : place + 1], key=lambda other: abs(other.at - one.at), default=None)
        if near is not None and abs(near.at - one.at) <= NEAR:
            pairs.append((one, near))
    return pairs


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else 0.0
