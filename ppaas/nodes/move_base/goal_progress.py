"""Progress to the active goal: what Nav2's feedback says besides the robot's pose."""

import math

from ppaas.controllers.followed_path import FollowedPath
from ppaas.geometry import Pose2D, Poses

MEMORY = 5.0
"""Time constant of the mean speed, from which the remaining time is estimated [s]."""

SLOWEST = 0.05
"""Speed below which a robot counts as waiting; the remaining time is then estimated with this speed [m/s]."""


class GoalProgress:
    """Distance and time that remain to the active goal.

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
        self._began = self._updated = 0.0
        self._speed = self._top_speed
        self.distance = 0.0

    def begin(self, goal: Pose2D, now: float) -> None:
        """Start to drive to a goal in the map frame."""
        self._goal, self._path = goal, None
        self._began = self._updated = now
        self._speed = self._top_speed

    def resume(self, spent: float) -> None:
        """Count the time for which the goal was active in another executor [s]."""
        self._began -= spent

    def follow(self, poses: Poses) -> None:
        """Measure along a new plan (n, 7); raises ``InvalidInput`` as `FollowedPath` does."""
        self._path = FollowedPath(poses)

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

    def spent(self, now: float) -> float:
        """Return the time since the goal became active [s]."""
        return max(now - self._began, 0.0)

    def remaining(self) -> float:
        """Return the estimated time to the goal [s]."""
        return self.distance / max(self._speed, SLOWEST)
