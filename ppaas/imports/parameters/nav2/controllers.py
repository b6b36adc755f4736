"""Parameters of the controller plug-ins DWB, MPPI and TEB."""

from ppaas.imports.parameters import elastic_band
from ppaas.imports.parameters.nav2.reasons import (
    BRAKES,
    OTHER_COSTS,
    SHOWN,
    SIDEWAYS,
    TOLERANCES,
    TRANSFORMS,
    WHOLE_PATH,
)
from ppaas.imports.parameters.nav2.tables import PluginTable, rules_of
from ppaas.imports.parameters.rules import without_effect
from ppaas.imports.parameters.values import above_zero, if_above_zero, magnitude, number, times, unless_zero, whole

# -- DWB ---------------------------------------------------------------------------------------------------------------

_DWB_SAME = "max_vel_x min_vel_x max_vel_theta acc_lim_x acc_lim_theta vx_samples sim_time"

_CRITICS = [
    "BaseObstacle",
    "GoalAlign",
    "GoalDist",
    "ObstacleFootprint",
    "Oscillation",
    "PathAlign",
    "PathDist",
    "PreferForward",
    "RotateToGoal",
    "Twirling",
    "PathHug",
]

_OF_CRITICS = {
    "scale": _CRITICS,
    "class": _CRITICS,
    "sum_scores": ("BaseObstacle", "ObstacleFootprint"),
    "max_scaling_factor": ("ObstacleFootprint",),
    "scaling_speed": ("ObstacleFootprint",),
    "aggregation_type": ("GoalAlign", "GoalDist", "PathAlign", "PathDist", "PathHug"),
    "forward_point_distance": ("GoalAlign", "PathAlign"),
    "search_window": ("PathHug",),
    "path_hug_distance": ("PathHug",),
    "oscillation_reset_dist": ("Oscillation",),
    "oscillation_reset_angle": ("Oscillation",),
    "oscillation_reset_time": ("Oscillation",),
    "x_only_threshold": ("Oscillation",),
    "penalty": ("PreferForward",),
    "strafe_x": ("PreferForward",),
    "strafe_theta": ("PreferForward",),
    "theta_scale": ("PreferForward",),
    "slowing_factor": ("RotateToGoal",),
    "lookahead_time": ("RotateToGoal",),
    "xy_goal_tolerance": ("RotateToGoal",),
    "trans_stopped_velocity": ("RotateToGoal",),
}

_DWB_CRITICS = " ".join(f"{critic}.{name}" for name, critics in _OF_CRITICS.items() for critic in critics)

DWB = PluginTable(
    "dwb_core::DWBLocalPlanner",
    rules_of("dwa", no_effect={"dwa has its own critics": f"critics default_critic_namespaces {_DWB_CRITICS}"})
    | rules_of(
        "dwa",
        _DWB_SAME,
        {
            "min_speed_xy": ("min_vel_trans", if_above_zero),
            "min_speed_theta": ("min_vel_theta", if_above_zero),
            "vtheta_samples": ("vth_samples", whole),
            "linear_granularity": ("sim_granularity", above_zero),
            "path_distance_bias": ("path_distance_bias", number),
            "goal_distance_bias": ("goal_distance_bias", number),
            "occdist_scale": ("occdist_scale", times(2.0), "the weights of both distances count twice here"),
            "PathDist.scale": ("path_distance_bias", number),
            "GoalDist.scale": ("goal_distance_bias", number),
            "BaseObstacle.scale": ("occdist_scale", times(2.0), "the weights of both distances count twice here"),
            "ObstacleFootprint.scale": ("occdist_scale", times(2.0), "the weights of both distances count twice here"),
            "PathAlign.forward_point_distance": ("forward_point_distance", magnitude),
        },
        {
            TOLERANCES: (
                "xy_goal_tolerance yaw_goal_tolerance trans_stopped_velocity rot_stopped_velocity stateful "
                "path_length_tolerance"
            ),
            SIDEWAYS: "max_vel_y min_vel_y acc_lim_y decel_lim_y vy_samples",
            BRAKES: "decel_lim_x decel_lim_theta",
            "max_vel_x limits the speed": "max_speed_xy",
            SHOWN: (
                "debug_trajectory_details publish_evaluation publish_global_plan publish_transformed_plan "
                "publish_local_plan publish_trajectories publish_cost_grid_pc marker_lifetime"
            ),
            WHOLE_PATH: "prune_plan prune_distance forward_prune_distance shorten_transformed_plan",
            TRANSFORMS: "transform_tolerance",
            "rollouts are sampled by distance and angle": (
                "angular_granularity discretize_by_time time_granularity include_last_point trajectory_generator_name "
                "limit_vel_cmd_in_traj sim_period"
            ),
            "all rollouts are scored to their end": "short_circuit_trajectory_evaluation",
            "the goal checker of the node counts": "goal_checker_name",
            "cost_slowdown of dwa slows the robot near obstacles": "max_scaling_factor scaling_speed",
        },
        {
            **dict.fromkeys(_DWB_SAME.split(), number),
            "max_vel_x": above_zero, "max_vel_theta": above_zero, "vx_samples": whole,
        },
    ),
    becomes="dwa",
)  # fmt: skip

# -- MPPI --------------------------------------------------------------------------------------------------------------

_MPPI_CRITICS = {
    "ConstraintCritic": "",
    "CostCritic": (
        "consider_footprint collision_cost critical_cost near_collision_cost near_goal_distance inflation_layer_name "
        "trajectory_point_step"
    ),
    "GoalCritic": "threshold_to_consider",
    "GoalAngleCritic": "threshold_to_consider symmetric_yaw_tolerance",
    "ObstaclesCritic": (
        "critical_weight repulsion_weight consider_footprint collision_cost collision_margin_distance "
        "near_goal_distance cost_scaling_factor inflation_radius inflation_layer_name"
    ),
    "PathAlignCritic": (
        "threshold_to_consider offset_from_furthest max_path_occupancy_ratio use_path_orientations "
        "trajectory_point_step path_point_step"
    ),
    "PathAlignLegacyCritic": (
        "threshold_to_consider offset_from_furthest max_path_occupancy_ratio use_path_orientations "
        "trajectory_point_step path_point_step"
    ),
    "PathAngleCritic": (
        "threshold_to_consider offset_from_furthest max_angle_to_furthest forward_preference mode"
    ),
    "PathFollowCritic": "threshold_to_consider offset_from_furthest",
    "PreferForwardCritic": "threshold_to_consider",
    "TwirlingCritic": "twirling_cost_power twirling_cost_weight",
    "VelocityDeadbandCritic": "deadband_velocities",
    "PathHugCritic": "threshold_to_consider offset_from_furthest",
}  # fmt: skip

_MPPI_CRITIC_NAMES = " ".join(
    f"{critic}.{name}"
    for critic, names in _MPPI_CRITICS.items()
    for name in ("enabled cost_power cost_weight " + names).split()
)

_MPPI_SAME = "batch_size time_steps model_dt iteration_count vx_std wz_std"

MPPI = PluginTable(
    "nav2_mppi_controller::MPPIController",
    rules_of("mppi", no_effect={OTHER_COSTS: _MPPI_CRITIC_NAMES})
    | rules_of(
        "mppi",
        _MPPI_SAME,
        {
            "vx_max": ("max_vel_x", above_zero),
            "vx_min": ("min_vel_x", number),
            "wz_max": ("max_vel_theta", above_zero),
            "ax_max": ("acc_lim_x", above_zero),
            "az_max": ("acc_lim_theta", above_zero),
            "model_delay_vx": ("command_delay", unless_zero),
            "ObstaclesCritic.collision_margin_distance": ("critical_distance", above_zero),
        },
        {
            OTHER_COSTS: "critics temperature gamma",
            SIDEWAYS: "vy_max vy_min vy_std ay_max ay_min model_delay_vy",
            BRAKES: "ax_min az_min",
            "command_delay holds for all velocities": "model_delay_wz",
            "the clone drives a base that turns in place": (
                "motion_model AckermannConstraints.min_turning_r AckermannConstrains.min_turning_r min_turning_r "
                "diff_drive.plugin omni.plugin "
                "ackermann.plugin ackermann.min_turning_r"
            ),
            SHOWN: (
                "visualize publish_optimal_trajectory publish_critics_stats critic_index_to_visualize "
                "TrajectoryVisualizer.trajectory_step TrajectoryVisualizer.time_step trajectory_step time_step"
            ),
            WHOLE_PATH: (
                "prune_distance max_robot_pose_search_dist enforce_path_inversion inversion_xy_tolerance "
                "inversion_yaw_tolerance enforce_path_rotation minimum_rotation_angle"
            ),
            TRANSFORMS: "transform_tolerance",
            "a blocked robot stops, and Move Base plans again or recovers": "retry_attempt_limit reset_period",
            "the variants are drawn once, by seed": "regenerate_noises",
            "the delay of the loop is measured": "open_loop controller_frequency",
            "the variants that are sent are free of collisions": (
                "TrajectoryValidator.plugin TrajectoryValidator.collision_lookahead_time "
                "TrajectoryValidator.consider_footprint collision_lookahead_time consider_footprint"
            ),
        },
        {
            **dict.fromkeys(_MPPI_SAME.split(), number),
            **dict.fromkeys(("batch_size", "time_steps", "iteration_count"), whole),
        },
    ),
    becomes="mppi",
)  # fmt: skip

TEB = PluginTable(
    "teb_local_planner::TebLocalPlannerROS",
    {
        **elastic_band.RULES,
        **without_effect(TOLERANCES, "xy_goal_tolerance yaw_goal_tolerance trans_stopped_vel theta_stopped_vel"),
        **without_effect(SIDEWAYS, "max_vel_trans"),
        **without_effect("the clone has the odometry and the frames of its robot", "odom_topic map_frame"),
        **without_effect(TRANSFORMS, "transform_tolerance"),
    },
    becomes="mppi",
)
