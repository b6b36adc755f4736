"""Progress to the active goal: what Nav2's feedback says besides the robot's pose."""

import math
from collections.abc import Sequence

import numpy as np

from ppaas.controllers.followed_path import FollowedPath
from ppaas.geometry import Pose2D, Poses, wrap_angle

MEMORY = 5.0
"""Time constant of the mean speed, from which the remaining time is estimated [s]."""

SLOWEST = 0.05
"""Speed below which a robot counts as waiting; the remaining time is then estimated with this speed [m/s]."""


PASSED = 0.5
"""Distance along the plan before a pose on the way at which it counts as passed [m]."""

BEYOND = 0.2
"""Distance beyond the next pose on the way to which the local planner sees the plan [m].

Its end must not be near the robot, which would stop there: a round trip ends where it begins. At the distance `PASSED`
from a pose, the local planner still sees more than the way on which it slows down.
"""


class GoalProgress:
    """Distance and time that remain to the active goal, and the poses on the way.

    The distance is that along the plan, or along the straight line before the first plan. The time is the distance
    divided by the mean speed of the last seconds; a robot that has just begun counts as fast as it may drive.

    Parameters
    ----------
    top_speed : float
        Fastest speed of the robot [m/s].

    Attributes
    ----------
    distance : float
        Remaining distance [m].
    """

    def __init__(self, top_speed: float) -> None:
        self._top_speed = max(top_speed, SLOWEST)
        self._goal = Pose2D(0.0, 0.0)
        self._path: FollowedPath | None = None
        self._poses: Poses = np.empty((0, 7))
        self._marks: list[float] = []
        self._began = self._updated = 0.0
        self._speed = self._top_speed
        self.distance = 0.0

    def begin(self, goal: Pose2D, now: float) -> None:
        """Start to drive to a goal in the map frame."""
        self._goal, self._path, self._marks = goal, None, []
        self._began = self._updated = now
        self._speed = self._top_speed

    def aim(self, goal: Pose2D) -> None:
        """Take the goal, which is elsewhere now."""
        self._goal = goal

    def resume(self, spent: float) -> None:
        """Count the time for which the goal was active in another executor [s]."""
        self._began -= spent

    def follow(self, poses: Poses, through: Sequence[Pose2D] = ()) -> None:
        """Measure along a new plan (n, 7) that passes poses; raises ``InvalidInput`` as `FollowedPath` does."""
        self._path, self._poses = FollowedPath(poses), poses
        self._marks, index = [], 0
        for pose in through:
            apart = np.hypot(*(poses[index:, :2] - pose[:2]).T)
            index += int(np.argmin(apart))
            self._marks.append(float(self._path.lengths[index]))

    @property
    def has_plan(self) -> bool:
        """Whether there is a plan to the active goal."""
        return self._path is not None

    @property
    def rest(self) -> Poses:
        """The plan from the robot to its end."""
        assert self._path is not None, "there is a plan"
        return self._poses[self._path.reached :]

    @property
    def ahead(self) -> Poses:
        """The plan from the robot to a little beyond the next pose on the way; to its end if there is none."""
        assert self._path is not None, "there is a plan"
        first, lengths = self._path.reached, self._path.lengths
        last = int(np.searchsorted(lengths, self._marks[0] + BEYOND, side="right")) if self._marks else len(lengths)
        return self._poses[first : max(last, first + 1)]

    def take_passed(self, pose: Pose2D) -> int:
        """Return how many poses on the way the robot has passed since the last call."""
        if self._path is None or not self._marks:
            return 0
        self._path.locate(pose)
        covered = float(self._path.lengths[self._path.reached])
        count = sum(mark - PASSED <= covered for mark in self._marks)
        self._marks = self._marks[count:]
        return count

    def take_next(self) -> int:
        """Count the next pose on the way as passed; return how many there were, 0 or 1."""
        count = min(len(self._marks), 1)
        self._marks = self._marks[count:]
        return count

    def update(self, pose: Pose2D, speed: float, now: float) -> None:
        """Take the pose in the map frame and the speed [m/s] of the robot."""
        weight = 1.0 - math.exp(-max(now - self._updated, 0.0) / MEMORY)
        self._speed += weight * (abs(speed) - self._speed)
        self._updated = now
        if self._path is None:
            self.distance = pose.distance_to(self._goal)
        else:
            self._path.locate(pose)
            self.distance = self._path.to_go(pose)

    def tracking_error(self, pose: Pose2D) -> tuple[float, float]:
        """Return how far a pose in the map frame is off the plan.

        Returns
        -------
        distance : float
            Distance from the plan [m], positive to the left of it; 0 without a plan.
        heading : float
            Heading against the direction of the plan [rad], from −π to π.
        """
        if self._path is None:
            return 0.0, 0.0
        first = min(self._path.reached, len(self._poses) - 2)
        if first < 0:
            return 0.0, 0.0
        (x, y), (next_x, next_y) = self._poses[first, :2], self._poses[first + 1, :2]
        way = math.atan2(next_y - y, next_x - x)
        left = (pose.y - y) * math.cos(way) - (pose.x - x) * math.sin(way)
        return float(left), wrap_angle(pose.theta - way)

    def spent(self, now: float) -> float:
        """Return the time since the goal became active [s]."""
        return max(now - self._began, 0.0)

    def remaining(self) -> float:
        """Return the estimated time to the goal [s]."""
        return self.distance / max(self._speed, SLOWEST)
