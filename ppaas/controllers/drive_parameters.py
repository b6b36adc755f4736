"""What every local planner's parameters have in common: limits, tolerances, and the robot's disc."""

import math
from dataclasses import dataclass, fields
from typing import ClassVar

from ppaas.controllers.base import VelocityLimits
from ppaas.controllers.footprints import Footprint, checked_footprint
from ppaas.errors import InvalidParameter
from ppaas.parameters import check_not_negative, check_scalar


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveParameters(VelocityLimits):
    """Parameters of a local planner; those of one algorithm add their own, and say what of them must be above 0.

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
    xy_goal_tolerance, yaw_goal_tolerance : float
        How near is there [m, rad].
    trans_stopped_vel, rot_stopped_vel : float
        Slower than this is standing still [m/s, rad/s].
    rotate_threshold : float
        Within the tolerance, a goal that lies off the heading by more than this need not be approached [rad].
    robot_radius : float
        Of the robot's disc [m].
    footprint : tuple of (x, y)
        Corners of its outline, which lies around the origin, in order [m]; none for a disc.
    allow_unknown : bool
        Whether unknown cells, and those outside the costmap, count as free.

    Raises
    ------
    InvalidParameter
        One is no number, not finite or out of range; the text names it.
    """

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta"})
    """Names of those that may not be 0; all but ``min_vel_x`` may not be less."""

    min_vel_trans: float = 0.05
    min_vel_theta: float = 0.2
    xy_goal_tolerance: float = 0.10
    yaw_goal_tolerance: float = 0.15
    trans_stopped_vel: float = 0.1
    rot_stopped_vel: float = 0.1
    rotate_threshold: float = math.pi / 3.0
    robot_radius: float = 0.18
    footprint: Footprint = ()
    allow_unknown: bool = True

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "footprint":
                object.__setattr__(self, field.name, checked_footprint(value))
                continue
            check_scalar(field.name, value, field.type)
            if field.name != "min_vel_x":
                check_not_negative(field.name, value, zero=field.name not in self.POSITIVE)
        if max(self.min_vel_x, self.min_vel_trans) > self.max_vel_x or self.min_vel_theta > self.max_vel_theta:
            raise InvalidParameter(
                "min_vel_x, min_vel_trans and min_vel_theta must not be above max_vel_x, max_vel_theta"
            )
