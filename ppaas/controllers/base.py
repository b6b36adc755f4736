"""Interface of local planners: what a controller receives in each control cycle and what it returns.

As in ``nav_core::BaseLocalPlanner``, a plan is set once, and a velocity is computed every cycle.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from ppaas.costmap.costmap import Costmap
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.geometry import Pose2D, Poses


class NoValidControl(PPaaSError):
    """Every velocity would lead to a collision."""

    slug = "no-valid-control"


class PathGivenUp(NoValidControl):
    """A robot that follows paths itself gave up; another plan would not help."""

    slug = "path-given-up"


class Velocity(NamedTuple):
    """Forward [m/s] and turning [rad/s] speed of a differential drive."""

    linear: float = 0.0
    angular: float = 0.0


@dataclass(frozen=True, slots=True)
class VelocityLimits:
    """Limits of the base, named as in base_local_planner [m/s, rad/s, m/s², rad/s²]."""

    max_vel_x: float = 0.5
    min_vel_x: float = 0.0
    max_vel_theta: float = 1.5
    acc_lim_x: float = 1.0
    acc_lim_theta: float = 3.0


class SpeedLimit(NamedTuple):
    """Temporary speed limit.

    Parameters
    ----------
    speed : float
        Fastest speed [m/s].
    part : float
        Largest part of the base's own ``max_vel_x``.
    """

    speed: float = math.inf
    part: float = 1.0

    def of(self, max_vel_x: float, slowest: float) -> float:
        """Return the fastest speed allowed [m/s], at least ``slowest``, below which the base does not move."""
        return max(min(self.speed, self.part * max_vel_x), min(slowest, max_vel_x))


NO_LIMIT = SpeedLimit()


@dataclass(frozen=True, slots=True)
class ControlRequest:
    """Input of one control cycle.

    Parameters
    ----------
    pose : Pose2D
        Pose of the robot in the frame of the plan and the local costmap, when the command takes effect.
    velocity : Velocity
        Velocity at that time.
    costmap : Costmap
        Local costmap: a window around the robot.
    period : float
        Time until the next cycle [s].
    threads : int
        Largest number of threads that kernels may use.
    movers : tuple of MovingObstacle
        Moving obstacles in the frame of the plan. The costmap contains them too, at their current positions.
    speed_limit : SpeedLimit
        Limit at this place and time, in addition to the limits of the base.
    """

    pose: Pose2D
    velocity: Velocity
    costmap: Costmap
    period: float = 0.1
    threads: int = 1
    movers: tuple[MovingObstacle, ...] = ()
    speed_limit: SpeedLimit = NO_LIMIT

    def check(self) -> None:
        """Check that the numbers are finite.

        Raises
        ------
        InvalidInput
            The pose, the velocity or the period is not finite, or the period is not positive.
        """
        if not (self.pose.is_finite() and all(map(math.isfinite, self.velocity))):
            raise InvalidInput(
                "the pose and the velocity of the robot must be finite; correct odometry or localization"
            )
        if not (math.isfinite(self.period) and self.period > 0.0):
            raise InvalidInput(f"the period must be a positive number of seconds, not {self.period}")


class Controller(ABC):
    """A local planner, found by an entry point in the group ``ppaas.controllers``."""

    name: ClassVar[str]
    purpose: ClassVar[str]
    predicts: ClassVar[bool] = False
    """Whether it predicts moving obstacles itself; otherwise the costmap contains their predicted positions."""

    @property
    def known_delay(self) -> float:
        """Delay of commands that the controller takes into account itself [s]; Move Base predicts the rest."""
        return 0.0

    @abstractmethod
    def set_plan(self, poses: Poses) -> None:
        """Follow this plan (n, 7) from now on."""

    @abstractmethod
    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return the velocity for this cycle.

        Raises
        ------
        NoValidControl
            Every velocity would collide: the caller must stop.
        """

    @abstractmethod
    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Return whether the robot stands still at the end of the plan, within the tolerances."""
