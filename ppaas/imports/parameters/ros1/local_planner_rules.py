"""Rules for the local planners of ROS 1: trajectory rollout and the dynamic window become dwa, elastic bands mppi."""

from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, renamed, same, without_effect
from ppaas.imports.parameters.values import at_least, negated

_DWA, _MPPI = "parameters.dwa.", "parameters.mppi."

_SIDEWAYS = "robots do not drive sideways here"
_DEBUG = "it is for debugging"
_RECONFIGURE = "it belongs to dynamic_reconfigure"
_STUCK = "a robot that is stuck recovers by move_base's recovery behaviours"
_ESCAPE = "the recovery behaviour back_up backs up"
_WEIGHTS = "weights of dwa have other units: those of dwa hold"
_CHECKED = "outlines are checked between the steps by their distance to obstacles"
_STOPS = "a robot can always stop before what its rollout touches"
_PRUNED = "the part of the plan behind the robot is never followed"
_LATCHED = "a robot at its goal turns in place, and does not come back for its position"
_TOPICS = "the topics are those of the robot: 'scan' and 'odom'"
_CYCLE = "it runs at move_base's controller_frequency"


FINEST = 0.05
"""Smallest tolerance within which ``mppi`` comes to rest [m]."""


TRAJECTORY: ParameterRules = {
    **same(
        _DWA, "max_vel_x", "min_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "xy_goal_tolerance",
        "yaw_goal_tolerance", "sim_time", "sim_granularity", "vx_samples",
    ),
    **renamed(
        _DWA, max_rotational_vel="max_vel_theta", acc_lim_th="acc_lim_theta", vtheta_samples="vth_samples",
        min_in_place_vel_theta="min_vel_theta", min_in_place_rotational_vel="min_vel_theta",
        rot_stopped_velocity="rot_stopped_vel", trans_stopped_velocity="trans_stopped_vel",
    ),
    "min_vel_theta": ParameterRule(text="turns to the right are as fast as those to the left"),
    **without_effect(
        _SIDEWAYS, "holonomic_robot", "y_vels", "acc_lim_y", "max_vel_y", "min_vel_y", "vy_samples", "strafe_in_place",
    ),
    **without_effect(_ESCAPE, "escape_vel", "backup_vel", "escape_reset_dist", "escape_reset_theta"),
    **without_effect(
        _WEIGHTS, "pdist_scale", "gdist_scale", "path_distance_bias", "goal_distance_bias", "occdist_scale",
        "meter_scoring",
    ),
    **without_effect(
        "rollouts are scored along the whole way", "heading_lookahead", "heading_scoring", "heading_scoring_timestep",
        "simple_attractor",
    ),
    **without_effect(_STUCK, "oscillation_reset_dist"),
    **without_effect(_CHECKED, "angular_sim_granularity", "world_model", "inscribed_radius", "circumscribed_radius"),
    **without_effect(_STOPS, "stop_time_buffer"),
    **without_effect(_PRUNED, "prune_plan"),
    **without_effect(_LATCHED, "latch_xy_goal_tolerance", "final_goal_distance_bias"),
    **without_effect(_CYCLE, "sim_period", "controller_frequency"),
    **without_effect(_DEBUG, "publish_cost_grid_pc", "publish_cost_grid", "publish_traj_pc"),
    **without_effect("xy_goal_tolerance is the distance to the goal", "x_goal_tolerance", "y_goal_tolerance"),
    **without_effect("frames are named in amcl or grid_slam", "global_frame_id", "odom_topic"),
    "dwa": ParameterRule(text="dwa always searches the velocities of the next cycle"),
    "point_grid": ParameterRule(text="obstacles are the cells of the local costmap"),
    **without_effect(
        "move_base does not read it: its names are acc_lim_x, acc_lim_th", "acc_limit_x", "acc_limit_y", "acc_limit_th",
    ),
    "restore_defaults": ParameterRule(text=_RECONFIGURE),
}  # fmt: skip
"""Rules of base_local_planner/TrajectoryPlannerROS."""

DYNAMIC_WINDOW: ParameterRules = {
    **same(
        _DWA, "max_vel_x", "min_vel_x", "min_vel_trans", "max_vel_theta", "min_vel_theta", "acc_lim_x",
        "acc_lim_theta", "xy_goal_tolerance", "yaw_goal_tolerance", "trans_stopped_vel", "rot_stopped_vel", "sim_time",
        "sim_granularity", "vx_samples", "vth_samples", "path_distance_bias", "goal_distance_bias", "occdist_scale",
        "forward_point_distance",
    ),
    **renamed(
        _DWA, min_trans_vel="min_vel_trans", max_rot_vel="max_vel_theta", min_rot_vel="min_vel_theta",
        acc_lim_th="acc_lim_theta", theta_stopped_vel="rot_stopped_vel", vtheta_samples="vth_samples",
    ),
    **without_effect("acc_lim_x bounds the acceleration", "acc_lim_trans", "acc_limit_trans"),
    **without_effect(_SIDEWAYS, "max_vel_y", "min_vel_y", "acc_lim_y", "vy_samples", "holonomic_robot", "holonomic"),
    **without_effect(_STUCK, "oscillation_reset_dist", "oscillation_reset_angle"),
    **without_effect("cost_slowdown of dwa slows a robot down near obstacles", "scaling_speed", "max_scaling_factor"),
    **without_effect("rollouts that turn need no less than those that do not", "twirling_scale", "penalize_negative_x"),
    **without_effect(_CHECKED, "angular_sim_granularity", "angular_granularity"),
    **without_effect(_STOPS, "stop_time_buffer"),
    **without_effect(_PRUNED, "prune_plan"),
    **without_effect(_LATCHED, "latch_xy_goal_tolerance"),
    **without_effect(_CYCLE, "sim_period", "controller_frequency"),
    **without_effect(_DEBUG, "publish_traj_pc", "publish_cost_grid_pc", "publish_cost_grid"),
    **without_effect("frames are named in amcl or grid_slam", "global_frame_id", "odom_topic"),
    "cheat_factor": ParameterRule(text=_WEIGHTS),
    "use_dwa": ParameterRule(text="dwa always searches the velocities of the next cycle"),
    "restore_defaults": ParameterRule(text=_RECONFIGURE),
}  # fmt: skip
"""Rules of dwa_local_planner/DWAPlannerROS, of which releases before Jade have other names."""

_BAND = "mppi tries sequences of commands in place of an elastic band"
_CLEARANCE = "mppi weighs clearance by critical_distance and repulsion_weight"
_MOVING = "mppi weighs moving obstacles by moving_distance and moving_weight"
_CLASSES = "mppi tries commands to all sides at once"
_CAR = "a base turns in place; the planner lattice keeps a minimum_turning_radius"
_COSTMAP = "obstacles are those of the local costmap"

ELASTIC_BAND: ParameterRules = {
    **same(
        _MPPI, "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "yaw_goal_tolerance", "trans_stopped_vel",
    ),
    "xy_goal_tolerance": ParameterRule(
        _MPPI + "xy_goal_tolerance", f"at least {FINEST}: mppi does not come to rest nearer to a goal", at_least(FINEST)
    ),
    "max_vel_x_backwards": ParameterRule(_MPPI + "min_vel_x", "reversing is a negative speed", negated),
    "theta_stopped_vel": ParameterRule(_MPPI + "rot_stopped_vel"),
    **without_effect(
        _BAND, "teb_autosize", "dt_ref", "dt_hysteresis", "min_samples", "max_samples", "exact_arc_length",
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
        "divergence_detection", "divergence_detection_max_chi_squared", "shrink_horizon_backup",
        "shrink_horizon_min_duration", "length_start_orientation_vector",
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
    **without_effect(_TOPICS, "odom_topic", "map_frame"),
    **without_effect(_DEBUG, "publish_feedback"),
    "free_goal_vel": ParameterRule(text="a robot stops at its goal"),
    "complete_global_plan": ParameterRule(text="a plan is driven to its end"),
    "footprint_model": ParameterRule(text="the outline is that of the costmaps: footprint or robot_radius"),
    "transform_tolerance": ParameterRule(text="scans may be as old as move_base's transform_tolerance"),
    "restore_defaults": ParameterRule(text=_RECONFIGURE),
}  # fmt: skip
"""Rules of teb_local_planner/TebLocalPlannerROS."""

TOP_SPEEDS = ("max_vel_trans", "max_trans_vel")
"""Parameters that bound ``max_vel_x``; of a robot that does not drive sideways, the lower one is its top speed."""
