"""Parameters that all local planners share: limits, goal tolerances and the robot's outline, also for the kernels."""

import math
from typing import ClassVar

import numpy as np

from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.errors import InvalidParameter
from ppaas.footprints import Footprint, goes_around
from ppaas.parameters import Parameters, check_numbers


def check_footprint(corners: Footprint) -> None:
    """Check the parameter ``footprint``.

    Raises
    ------
    InvalidParameter
        It has one or two corners, a number is not finite, or it does not go around the origin in one direction.
    """
    if corners and not goes_around(corners):
        raise InvalidParameter(
            "footprint must be a list of corners (x, y) [m], in order around the robot's origin: none for a disc, or "
            f"at least three, not {corners!r}"
        )


def body_of(footprint: Footprint, robot_radius: float) -> RobotOutline:
    """Return the outline of a robot for the kernels, from its footprint, or from its radius [m] if that is empty."""
    corners = np.array(footprint, dtype=np.float64).reshape(-1, 2)
    vectors = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(vectors[:, 0], vectors[:, 1])[:, None]
    edges = np.hstack((corners, vectors / lengths, lengths))
    if not len(corners):
        return RobotOutline(edges, robot_radius, robot_radius)
    # Distance of each edge's line from the origin: cross product of a corner with the edge's unit direction.
    beside = np.abs(edges[:, 0] * edges[:, 3] - edges[:, 1] * edges[:, 2])
    return RobotOutline(edges, float(beside.min()), float(np.hypot(corners[:, 0], corners[:, 1]).max()))


class DriveParameters(Parameters, frozen=True, kw_only=True):
    """Parameters of a local planner; each algorithm derives from them and adds its own.

    Parameters
    ----------
    max_vel_x, min_vel_x : float
        Fastest and slowest forward speed [m/s]; a negative ``min_vel_x`` allows reversing.
    min_vel_trans : float
        Speed below which a real base does not move [m/s].
    max_vel_theta, min_vel_theta : float
        Fastest turn, and slowest turn in place, below which a real base does not move [rad/s].
    acc_lim_x, acc_lim_theta : float
        Limits of acceleration and braking [m/s², rad/s²].
    xy_goal_tolerance, yaw_goal_tolerance : float
        Distance and angle within which the goal is reached [m, rad].
    trans_stopped_vel, rot_stopped_vel : float
        Speeds below which the robot stands still [m/s, rad/s].
    rotate_threshold : float
        Angle from the heading above which a goal within the tolerance is not approached any more [rad].
    robot_radius : float
        Radius of the robot [m].
    footprint : tuple of (x, y)
        Corners of the outline around the robot's origin, in order [m]; empty for a disc.
    allow_unknown : bool
        Whether unknown cells, and cells outside the costmap, count as free.

    Raises
    ------
    InvalidParameter
        A value is not a number, not finite or out of range; the text names the parameter.
    """

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta"})
    """Names of the parameters that must be above 0; all others except ``min_vel_x`` must be at least 0."""

    max_vel_x: float = 0.5
    min_vel_x: float = 0.0
    max_vel_theta: float = 1.5
    acc_lim_x: float = 1.0
    acc_lim_theta: float = 3.0
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
        """Check the ranges."""
        check_numbers(self, positive=self.POSITIVE, signed=("min_vel_x",))
        check_footprint(self.footprint)
        if max(self.min_vel_x, self.min_vel_trans) > self.max_vel_x or self.min_vel_theta > self.max_vel_theta:
            raise InvalidParameter(
                "min_vel_x and min_vel_trans must be at most max_vel_x, and min_vel_theta at most max_vel_theta"
            )
