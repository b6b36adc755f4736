"""What a local planner is given and what it gives.

The interface of ``nav_core::BaseLocalPlanner``: a plan is set once, then velocities are asked for every cycle.
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
    """No velocity is free of collision."""

    slug = "no-valid-control"


class Velocity(NamedTuple):
    """Forward [m/s] and turning [rad/s] speed of a differential drive."""

    linear: float = 0.0
    angular: float = 0.0


@dataclass(frozen=True, slots=True)
class VelocityLimits:
    """What the base can do, with the names of base_local_planner [m/s, rad/s, m/s², rad/s²]."""

    max_vel_x: float = 0.5
    min_vel_x: float = 0.0
    max_vel_theta: float = 1.5
    acc_lim_x: float = 1.0
    acc_lim_theta: float = 3.0


class SpeedLimit(NamedTuple):
    """How fast a robot is to drive at most: so many m/s, and no more than a part of what it may at other times."""

    speed: float = math.inf
    part: float = 1.0

    def of(self, limits: VelocityLimits, slowest: float) -> float:
        """Return the fastest that it is to drive [m/s]: no less than ``slowest``, below which no base moves."""
        return max(min(self.speed, self.part * limits.max_vel_x), min(slowest, limits.max_vel_x))


NO_LIMIT = SpeedLimit()


@dataclass(frozen=True, slots=True)
class ControlRequest:
    """What is known at one control cycle.

    Parameters
    ----------
    pose : Pose2D
        Of the robot, in the frame of the plan and the local costmap.
    velocity : Velocity
        As odometry measured it.
    costmap : Costmap
        Local: a window around the robot.
    period : float
        Seconds until the next cycle.
    threads : int
        Most threads that kernels may use.
    movers : tuple of MovingObstacle
        Who moves there now, in the frame of the plan. They are in the costmap, too, where they are.
    speed_limit : SpeedLimit
        What it is to keep to here and now, beside the limits of its base.
    """

    pose: Pose2D
    velocity: Velocity
    costmap: Costmap
    period: float = 0.1
    threads: int = 1
    movers: tuple[MovingObstacle, ...] = ()
    speed_limit: SpeedLimit = NO_LIMIT

    def check(self) -> None:
        """Let it pass if a controller can work with it.

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
    """Whether it minds where movers will be; else the costmap tells it of where they will be as of obstacles."""

    @abstractmethod
    def set_plan(self, poses: Poses) -> None:
        """Follow this (n, 7) plan from now on."""

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
        """Tell whether the end of the plan is reached within the tolerances and the robot stands still."""
