"""The parameters of the dynamic window, with the names and mostly the defaults of dwa_local_planner."""

import math
from dataclasses import dataclass, fields

from ppaas.errors import InvalidParameter
from ppaas.parameter_types import check_scalar

_POSITIVE = ("max_vel_x", "max_vel_theta", "min_vel_trans", "acc_lim_x", "acc_lim_theta", "sim_time", "sim_granularity")
_SIGNED = ("min_vel_x",)


@dataclass(frozen=True, slots=True, kw_only=True)
class DwaParameters:
    """What can be set.

    Parameters
    ----------
    max_vel_x, min_vel_x : float
        Fastest and slowest forward speed [m/s]; a negative one lets it back up.
    min_vel_trans : float
        Below this speed a real base does not move [m/s].
    max_vel_theta, min_vel_theta : float
        Fastest turn, and slowest on the spot: below it a real base does not move [rad/s].
    acc_lim_x, acc_lim_theta : float
        Acceleration and braking [m/s², rad/s²].
    sim_time : float
        How far rollouts look ahead [s].
    sim_granularity : float
        Step of a rollout [m].
    vx_samples, vth_samples : int
        Forward and turning speeds tried.
    path_distance_bias, goal_distance_bias : float
        What a metre off the path, and a metre still to go, count.
    occdist_scale : float
        What a unit of the highest cost met counts.
    forward_point_distance : float
        A point so far in front of the robot should be on the path too [m].
    cost_slowdown : float
        Part of the speed that is taken off where the cost is highest, 0 to 1.
    xy_goal_tolerance, yaw_goal_tolerance : float
        How near is there [m, rad].
    trans_stopped_vel, rot_stopped_vel : float
        Slower than this is standing still [m/s, rad/s].
    rotate_threshold : float
        It turns on the spot if the path leads off by more than this [rad].
    robot_radius : float
        Of its disc [m]. Collisions are read off the inflated costmap; this sets how far ahead it looks for the way
        the path leads, and how far it may go to leave an inscribed cell.
    allow_unknown : bool
        Whether unknown cells, and those outside the costmap, count as free.

    Raises
    ------
    InvalidParameter
        One is no number, not finite or out of range; the text names it.
    """

    max_vel_x: float = 0.5
    min_vel_x: float = 0.0
    min_vel_trans: float = 0.05
    max_vel_theta: float = 1.5
    min_vel_theta: float = 0.2
    acc_lim_x: float = 1.0
    acc_lim_theta: float = 3.0
    sim_time: float = 1.7
    sim_granularity: float = 0.025
    vx_samples: int = 8
    vth_samples: int = 20
    path_distance_bias: float = 32.0
    goal_distance_bias: float = 24.0
    occdist_scale: float = 0.1
    forward_point_distance: float = 0.2
    cost_slowdown: float = 0.5
    xy_goal_tolerance: float = 0.10
    yaw_goal_tolerance: float = 0.15
    trans_stopped_vel: float = 0.1
    rot_stopped_vel: float = 0.1
    rotate_threshold: float = math.pi / 3.0
    robot_radius: float = 0.18
    allow_unknown: bool = True

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            check_scalar(field.name, value, field.type)
            _check_range(field.name, value, field.type)
        if max(self.min_vel_x, self.min_vel_trans) > self.max_vel_x or self.min_vel_theta > self.max_vel_theta:
            raise InvalidParameter(
                "min_vel_x, min_vel_trans and min_vel_theta must not be above max_vel_x, max_vel_theta"
            )
        if self.cost_slowdown >= 1.0:
            raise InvalidParameter(f"cost_slowdown must be below 1, not {self.cost_slowdown}: the robot would stop")


def _check_range(name: str, value: bool | float, kind: object) -> None:
    least_excluded = name in _POSITIVE
    if (value <= 0 if least_excluded else value < 0) and name not in _SIGNED and kind is not bool:
        raise InvalidParameter(f"{name} must be {'above' if least_excluded else 'at least'} 0, not {value}")
    if kind is int and value < 1:
        raise InvalidParameter(f"{name} must be at least 1, not {value}")
