"""Rules for the elastic bands of teb_local_planner, of ROS 1 and of ROS 2, which become mppi."""

from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, same, without_effect
from ppaas.imports.parameters.values import above_zero, negated

_MPPI = "parameters.mppi."

_BAND = "mppi tries sequences of commands in place of an elastic band"
_CLEARANCE = "mppi weighs clearance by critical_distance and repulsion_weight"
_MOVING = "mppi weighs moving obstacles by moving_distance and moving_weight"
_CLASSES = "mppi tries commands to all sides at once"
_CAR = "a base turns in place; the planner lattice keeps a minimum_turning_radius"
_COSTMAP = "obstacles are the cells of the local costmap"
_SIDEWAYS = "robots do not drive sideways here"
_STUCK = "a robot that is stuck recovers by the recovery behaviours of Move Base"

RULES: ParameterRules = {
    **same(_MPPI, "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", convert=above_zero),
    "max_vel_x_backwards": ParameterRule(_MPPI + "min_vel_x", "reversing is a negative speed", negated),
    **without_effect(
        _BAND, "teb_autosize", "use_gpu", "min_vel_theta", "dt_ref", "dt_hysteresis", "min_samples", "max_samples",
        "exact_arc_length",
        "global_plan_overwrite_orientation", "allow_init_with_backwards_motion", "global_plan_viapoint_sep",
        "global_plan_via_point_sep", "via_points_ordered", "max_global_plan_lookahead_dist",
        "global_plan_prune_distance", "force_reinit_new_goal_dist", "force_reinit_new_goal_angular",
        "feasibility_check_no_poses", "feasibility_check_lookahead_distance",
        "min_resolution_collision_check_angular", "control_look_ahead_poses", "prevent_look_ahead_poses_near_goal",
        "no_inner_iterations", "no_outer_iterations", "optimization_activate", "optimization_verbose",
        "penalty_epsilon", "weight_max_vel_x", "weight_max_vel_y", "weight_max_vel_theta", "weight_acc_lim_x",
        "weight_acc_lim_y", "weight_acc_lim_theta", "weight_kinematics_nh", "weight_kinematics_forward_drive",
        "weight_kinematics_turning_radius", "weight_optimaltime", "weight_shortest_path", "weight_viapoint",
        "weight_prefer_rotdir", "weight_adapt_factor", "weight_velocity_obstacle_ratio", "obstacle_cost_exponent",
        "divergence_detection", "divergence_detection_enable", "divergence_detection_max_chi_squared",
        "shrink_horizon_backup", "shrink_horizon_min_duration", "length_start_orientation_vector",
    ),
    **without_effect(
        _CLEARANCE, "min_obstacle_dist", "inflation_dist", "weight_obstacle", "weight_inflation",
        "obstacle_proximity_ratio_max_vel", "obstacle_proximity_lower_bound", "obstacle_proximity_upper_bound",
    ),
    **without_effect(
        _MOVING, "dynamic_obstacle_inflation_dist", "include_dynamic_obstacles", "weight_dynamic_obstacle",
        "weight_dynamic_obstacle_inflation", "is_footprint_dynamic",
    ),
    **without_effect(
        _COSTMAP, "include_costmap_obstacles", "costmap_obstacles_behind_robot_dist", "obstacle_poses_affected",
        "legacy_obstacle_association", "obstacle_association_force_inclusion_factor",
        "obstacle_association_cutoff_factor", "costmap_converter_plugin", "costmap_converter_spin_thread",
        "costmap_converter_rate", "costmap_converter", "costmap_converter/CostmapToLinesDBSRANSAC",
    ),
    **without_effect(
        _CLASSES, "enable_homotopy_class_planning", "enable_multithreading", "simple_exploration", "max_number_classes",
        "max_number_plans_in_current_class", "selection_obst_cost_scale", "selection_prefer_initial_plan",
        "selection_viapoint_cost_scale", "selection_cost_hysteresis", "selection_alternative_time_cost",
        "selection_dropping_probability", "switching_blocking_period", "roadmap_graph_samples",
        "roadmap_graph_no_samples", "roadmap_graph_area_width", "roadmap_graph_area_length_scale",
        "h_signature_prescaler", "h_signature_threshold", "obstacle_keypoint_offset", "obstacle_heading_threshold",
        "viapoints_all_candidates", "visualize_hc_graph", "visualize_with_time_as_z_axis_scale",
        "delete_detours_backwards", "detours_orientation_tolerance", "max_ratio_detours_duration_best_duration",
    ),
    **without_effect(_CAR, "min_turning_radius", "wheelbase", "cmd_angle_instead_rotvel"),
    **without_effect(_SIDEWAYS, "max_vel_y", "acc_lim_y", "use_proportional_saturation"),
    **without_effect(
        _STUCK, "oscillation_recovery", "oscillation_v_eps", "oscillation_omega_eps",
        "oscillation_recovery_min_duration", "oscillation_filter_duration",
    ),
    **without_effect("it is for debugging", "publish_feedback"),
    **without_effect("a robot stops at its goal", "free_goal_vel"),
    **without_effect("a plan is driven to its end", "complete_global_plan"),
    **without_effect("the outline is that of the costmaps: footprint or robot_radius", "footprint_model"),
}  # fmt: skip
"""Rules without the ones of tolerances, which Nav2 gives to its goal checkers. ``min_obstacle_dist`` has no effect: it
is measured from the model of the outline, by default a point, and ours from the outline itself."""
