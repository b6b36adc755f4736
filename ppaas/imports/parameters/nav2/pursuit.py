"""Parameters of the controller plug-ins that become pure pursuit, and of the shim around a controller."""

from ppaas.imports.parameters.nav2.reasons import BRAKES, TOLERANCES, TRANSFORMS, WHOLE_PATH
from ppaas.imports.parameters.nav2.tables import Given, PluginTable, rules_of
from ppaas.imports.parameters.rules import Convert, without_effect
from ppaas.imports.parameters.values import above_zero, flag, number, unless_zero

ONE_LAW = "pure_pursuit has another law of steering"

_FLAGS = (
    "use_velocity_scaled_lookahead_dist use_fixed_curvature_lookahead use_rotate_to_heading allow_reversing "
    "use_regulated_linear_velocity_scaling use_cost_regulated_linear_velocity_scaling use_collision_detection"
)

_PURSUIT_SAME = (
    f"{_FLAGS} lookahead_dist min_lookahead_dist max_lookahead_dist lookahead_time curvature_lookahead_dist "
    "rotate_to_heading_min_angle rotate_to_heading_angular_vel regulated_linear_scaling_min_radius "
    "regulated_linear_scaling_min_speed cost_scaling_dist cost_scaling_gain inflation_cost_scaling_factor "
    "approach_velocity_scaling_dist min_approach_linear_velocity max_allowed_time_to_collision_up_to_carrot"
)

_PURSUIT_CONVERT: dict[str, Convert] = {
    **dict.fromkeys(_PURSUIT_SAME.split(), number),
    **dict.fromkeys(_FLAGS.split(), flag),
}

_SPEEDS: dict[str, Given] = {
    "desired_linear_vel": ("max_vel_x", above_zero),
    "max_angular_accel": ("acc_lim_theta", above_zero),
}

_PURSUIT_NONE = {
    TRANSFORMS: "transform_tolerance",
    WHOLE_PATH: "max_robot_pose_search_dist interpolate_curvature_after_goal use_interpolation",
    TOLERANCES: "stateful goal_dist_tol xy_goal_tolerance yaw_goal_tolerance",
    "a cancelled robot brakes as it accelerates": "use_cancel_deceleration cancel_deceleration",
}

PURE_PURSUIT = PluginTable(
    "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
    rules_of(
        "pure_pursuit",
        _PURSUIT_SAME,
        {
            **_SPEEDS,
            "max_linear_vel": ("max_vel_x", above_zero),
            "min_linear_vel": ("min_vel_x", number),
            "max_angular_vel": ("max_vel_theta", above_zero),
            "max_linear_accel": ("acc_lim_x", above_zero),
            "max_allowed_time_to_collision": ("max_allowed_time_to_collision_up_to_carrot", number),
        },
        {
            **_PURSUIT_NONE,
            BRAKES: "max_linear_decel max_angular_decel min_angular_accel",
            "the arc is checked by the outline of the robot": (
                "min_distance_to_obstacle allow_obstacle_checking_beyond_goal"
            ),
            "speed follows from curvature, cost and distance": (
                "use_dynamic_window use_approach_linear_velocity_scaling use_approach_vel_scaling min_angular_vel "
                "max_linear_jerk"
            ),
        },
        _PURSUIT_CONVERT,
    ),
    becomes="pure_pursuit",
)

_VECTOR_SAME = (
    "lookahead_dist min_lookahead_dist max_lookahead_dist lookahead_time use_velocity_scaled_lookahead_dist "
    "use_collision_detection use_cost_regulated_linear_velocity_scaling allow_reversing cost_scaling_dist "
    "cost_scaling_gain inflation_cost_scaling_factor use_rotate_to_heading rotate_to_heading_min_angle "
    "rotate_to_heading_angular_vel approach_velocity_scaling_dist min_approach_linear_velocity"
)

VECTOR_PURSUIT = PluginTable(
    "vector_pursuit_controller::VectorPursuitController",
    rules_of(
        "pure_pursuit",
        _VECTOR_SAME,
        {
            **_SPEEDS,
            "max_linear_accel": ("acc_lim_x", above_zero),
            "min_linear_velocity": ("regulated_linear_scaling_min_speed", unless_zero),
            "max_allowed_time_to_collision_up_to_target": ("max_allowed_time_to_collision_up_to_carrot", number),
        },
        {
            **_PURSUIT_NONE,
            ONE_LAW: "p_gain use_heading_from_path",
            "a planner keeps to a turning radius: lattice": "min_turning_radius",
            "curves reduce the speed by their radius": "max_lateral_accel",
        },
        _PURSUIT_CONVERT,
    ),
    becomes="pure_pursuit",
)

GRACEFUL = PluginTable(
    "nav2_graceful_controller::GracefulController",
    rules_of(
        "pure_pursuit",
        "use_collision_detection",
        {
            "max_lookahead": ("lookahead_dist", above_zero),
            "min_lookahead": ("min_lookahead_dist", above_zero),
            "v_linear_max": ("max_vel_x", above_zero),
            "v_linear_min": ("min_approach_linear_velocity", unless_zero),
            "v_angular_max": ("max_vel_theta", above_zero),
            "v_angular_min_in_place": ("min_vel_theta", unless_zero),
            "slowdown_radius": ("approach_velocity_scaling_dist", above_zero),
            "initial_rotation": ("use_rotate_to_heading", flag),
            "initial_rotation_tolerance": ("rotate_to_heading_min_angle", number),
            "initial_rotation_threshold": ("rotate_to_heading_min_angle", number),
            "initial_rotation_min_angle": ("rotate_to_heading_min_angle", number),
            "allow_backward": ("allow_reversing", flag),
            "motion_target_dist": ("lookahead_dist", above_zero),
        },
        {
            TRANSFORMS: "transform_tolerance",
            WHOLE_PATH: "max_robot_pose_search_dist",
            ONE_LAW: "k_phi k_delta beta lambda k1 k2 deceleration_max final_rotation",
            "the robot follows its path, and turns to the heading of the goal there": "prefer_final_rotation",
            "turns are as fast as the robot can brake": "rotation_scaling_factor",
            "turns in place are checked by the outline of the robot": (
                "in_place_collision_resolution in_place_collision_tolerance"
            ),
            "the outline of the robot keeps its size at every speed": (
                "footprint_scaling_linear_vel footprint_scaling_factor footprint_scaling_step"
            ),
            "the last metres follow the path, which a planner leads around obstacles": (
                "obstacle_cost_margin final_rotation_search_step"
            ),
        },
        {"use_collision_detection": flag},
    ),
    becomes="pure_pursuit",
)

SHIM = PluginTable(
    "nav2_rotation_shim_controller::RotationShimController",
    without_effect(
        "the local planner turns to its path by its own threshold, and to the heading of the goal",
        "angular_dist_threshold angular_disengage_threshold forward_sampling_distance rotate_to_goal_heading "
        "rotate_to_heading_once closed_loop use_path_orientations simulate_ahead_time rotate_to_heading_angular_vel "
        "max_angular_accel primary_controller primary_controller.plugin",
    ),
)
"""What the shim itself does without; its primary controller's table has its other parameters."""

SHIM_OF_PURSUIT = rules_of(
    "pure_pursuit",
    "rotate_to_heading_angular_vel",
    {
        "angular_dist_threshold": ("rotate_to_heading_min_angle", number),
        "max_angular_accel": ("acc_lim_theta", above_zero),
    },
    convert={"rotate_to_heading_angular_vel": number},
)

SHIM_OF_DWA = rules_of(
    "dwa",
    converted={
        "angular_dist_threshold": ("rotate_threshold", number),
        "max_angular_accel": ("acc_lim_theta", above_zero),
    },
)

SHIM_OF_MPPI = rules_of("mppi", converted={"max_angular_accel": ("acc_lim_theta", above_zero)})

OF_SHIM = {"pure_pursuit": SHIM_OF_PURSUIT, "dwa": SHIM_OF_DWA, "mppi": SHIM_OF_MPPI}
"""Rules of the shim's own parameters, by the local planner that its primary controller becomes."""
