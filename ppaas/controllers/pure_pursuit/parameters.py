"""The parameters of regulated pure pursuit: limits as base_local_planner names them, all else as Nav2's controller."""

from dataclasses import dataclass
from typing import ClassVar

from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR
from ppaas.errors import InvalidParameter


@dataclass(frozen=True, slots=True, kw_only=True)
class PurePursuitParameters(DriveParameters):
    """What can be set, beside what all local planners have; ``max_vel_x`` is the speed that is wanted in the open.

    Parameters
    ----------
    lookahead_dist : float
        How far away the point of the path is that it steers to [m].
    use_velocity_scaled_lookahead_dist : bool
        Whether that is how far it comes in ``lookahead_time`` instead.
    min_lookahead_dist, max_lookahead_dist : float
        Limits of that [m]; down to the former it looks, too, for an arc that is free.
    lookahead_time : float
        See above [s].
    use_fixed_curvature_lookahead, curvature_lookahead_dist : bool, float
        Whether speed follows the curvature of the path to a point so far away [m], instead of that of the arc.
    use_rotate_to_heading : bool
        Whether it turns on the spot where the path leads off.
    rotate_to_heading_min_angle, rotate_to_heading_angular_vel : float
        By how much that must be [rad], and how fast it turns then [rad/s].
    allow_reversing : bool
        Whether it drives backwards to what is behind it, no faster than ``min_vel_x`` says, and so along a plan that
        turns back on itself.
    use_regulated_linear_velocity_scaling : bool
        Whether it is slower in curves.
    regulated_linear_scaling_min_radius, regulated_linear_scaling_min_speed : float
        Radius from which it is slower [m], and the speed that neither a curve nor an obstacle takes away [m/s].
    use_cost_regulated_linear_velocity_scaling : bool
        Whether it is slower near obstacles.
    cost_scaling_dist, cost_scaling_gain : float
        Distance from which it is slower [m], and what its speed there is multiplied with, at most 1.
    inflation_cost_scaling_factor : float
        That of the local costmap, to tell distances by costs [1/m].
    approach_velocity_scaling_dist, min_approach_linear_velocity : float
        How far from the end of the path it begins to be slower [m], and the least speed of that [m/s].
    use_collision_detection, max_allowed_time_to_collision_up_to_carrot : bool, float
        Whether the way to that point must be free, for so many seconds.

    Raises
    ------
    InvalidParameter
        One is no number, not finite or out of range; the text names it.
    """

    POSITIVE: ClassVar[frozenset[str]] = DriveParameters.POSITIVE | {
        "lookahead_dist", "min_lookahead_dist", "lookahead_time", "curvature_lookahead_dist",
        "rotate_to_heading_angular_vel", "regulated_linear_scaling_min_radius", "cost_scaling_dist",
        "cost_scaling_gain", "inflation_cost_scaling_factor", "approach_velocity_scaling_dist",
        "min_approach_linear_velocity", "max_allowed_time_to_collision_up_to_carrot",
    }  # fmt: skip

    lookahead_dist: float = 0.6
    use_velocity_scaled_lookahead_dist: bool = False
    min_lookahead_dist: float = 0.3
    max_lookahead_dist: float = 0.9
    lookahead_time: float = 1.5
    use_fixed_curvature_lookahead: bool = False
    curvature_lookahead_dist: float = 0.6
    use_rotate_to_heading: bool = True
    rotate_to_heading_min_angle: float = 0.785
    rotate_to_heading_angular_vel: float = 1.8
    allow_reversing: bool = False
    use_regulated_linear_velocity_scaling: bool = True
    regulated_linear_scaling_min_radius: float = 0.9
    regulated_linear_scaling_min_speed: float = 0.25
    use_cost_regulated_linear_velocity_scaling: bool = True
    cost_scaling_dist: float = 0.6
    cost_scaling_gain: float = 1.0
    inflation_cost_scaling_factor: float = COST_SCALING_FACTOR
    approach_velocity_scaling_dist: float = 0.6
    min_approach_linear_velocity: float = 0.05
    use_collision_detection: bool = True
    max_allowed_time_to_collision_up_to_carrot: float = 1.0

    def __post_init__(self) -> None:
        DriveParameters.__post_init__(self)
        if self.min_lookahead_dist > self.max_lookahead_dist:
            raise InvalidParameter("min_lookahead_dist must not be above max_lookahead_dist")
        if self.cost_scaling_gain > 1.0:
            raise InvalidParameter(f"cost_scaling_gain must be at most 1, not {self.cost_scaling_gain}")
        if self.rotate_to_heading_angular_vel < self.min_vel_theta:
            raise InvalidParameter("rotate_to_heading_angular_vel must not be below min_vel_theta")
        if self.allow_reversing and self.min_vel_x >= 0.0:
            raise InvalidParameter("allow_reversing wants a min_vel_x below 0: how fast it may drive backwards")
