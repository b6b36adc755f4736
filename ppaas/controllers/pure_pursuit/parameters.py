"""Parameters of regulated pure pursuit: limits named as in base_local_planner, all others as in Nav2's controller."""

from typing import ClassVar

from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR
from ppaas.errors import InvalidParameter


class PurePursuitParameters(DriveParameters, frozen=True, kw_only=True):
    """Parameters in addition to all local planners' parameters; ``max_vel_x`` is the desired speed in free space.

    Parameters
    ----------
    lookahead_dist : float
        Distance to the point of the path that the robot steers towards (the carrot) [m].
    use_velocity_scaled_lookahead_dist : bool
        Whether that distance is instead the one driven in ``lookahead_time``.
    min_lookahead_dist, max_lookahead_dist : float
        Limits of the scaled distance [m]; if an arc is not free, nearer carrots are tried down to the former.
    lookahead_time : float
        Time of the scaled distance [s].
    use_fixed_curvature_lookahead, curvature_lookahead_dist : bool, float
        Whether the speed depends on the curvature to a point at that fixed distance [m], instead of the carrot's.
    use_rotate_to_heading : bool
        Whether the robot turns in place if the path leads in another direction.
    rotate_to_heading_min_angle, rotate_to_heading_angular_vel : float
        Smallest angle of such a turn [rad], and its speed [rad/s].
    allow_reversing : bool
        Whether the robot reverses towards a carrot behind it, at most at the speed of ``min_vel_x``, and follows plans
        that reverse direction.
    use_regulated_linear_velocity_scaling : bool
        Whether the robot slows down in curves.
    regulated_linear_scaling_min_radius, regulated_linear_scaling_min_speed : float
        Radius of curves below which it slows down [m], and the lowest speed in curves and near obstacles [m/s].
    use_cost_regulated_linear_velocity_scaling : bool
        Whether the robot slows down near obstacles.
    cost_scaling_dist, cost_scaling_gain : float
        Distance to obstacles below which it slows down [m], and the factor of its speed there, at most 1.
    inflation_cost_scaling_factor : float
        Scaling factor of the local costmap, to convert costs into distances [1/m].
    approach_velocity_scaling_dist, min_approach_linear_velocity : float
        Distance from the end of the path at which the robot slows down [m], and its lowest speed there [m/s].
    use_collision_detection, max_allowed_time_to_collision_up_to_carrot : bool, float
        Whether the arc to the carrot must be free of collisions, and for how long [s].

    Raises
    ------
    InvalidParameter
        A value is not a number, not finite or out of range; the text names the parameter.
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
        """Check the ranges."""
        super().__post_init__()
        if self.min_lookahead_dist > self.max_lookahead_dist:
            raise InvalidParameter("min_lookahead_dist must be at most max_lookahead_dist")
        if self.cost_scaling_gain > 1.0:
            raise InvalidParameter(f"cost_scaling_gain must be at most 1, not {self.cost_scaling_gain}")
        if self.rotate_to_heading_angular_vel < self.min_vel_theta:
            raise InvalidParameter("rotate_to_heading_angular_vel must be at least min_vel_theta")
        if self.allow_reversing and self.min_vel_x >= 0.0:
            raise InvalidParameter("allow_reversing requires min_vel_x below 0, the fastest speed in reverse")
