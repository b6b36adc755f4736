"""Parameters of the controller plug-in TEB."""

from ppaas.imports.parameters.nav2.reasons import OTHER_COSTS, SHOWN, SIDEWAYS, TOLERANCES
from ppaas.imports.parameters.nav2.tables import PluginTable, rules_of
from ppaas.imports.parameters.values import above_zero, negated

TEB = PluginTable(
    "teb_local_planner::TebLocalPlannerROS",
    rules_of(
        "mppi",
        "max_vel_x max_vel_theta acc_lim_x acc_lim_theta",
        {
            "max_vel_x_backwards": ("min_vel_x", negated),
            "min_obstacle_dist": ("critical_distance", above_zero),
        },
        {
            TOLERANCES: (
                "xy_goal_tolerance yaw_goal_tolerance free_goal_vel complete_global_plan trans_stopped_vel "
                "theta_stopped_vel"
            ),
            SIDEWAYS: "max_vel_y acc_lim_y max_vel_trans weight_max_vel_y weight_acc_lim_y use_proportional_saturation",
            "mppi tries variants of commands instead of bands of poses": (
                "teb_autosize dt_ref dt_hysteresis min_samples max_samples global_plan_overwrite_orientation "
                "allow_init_with_backwards_motion global_plan_viapoint_sep via_points_ordered "
                "max_global_plan_lookahead_dist global_plan_prune_distance exact_arc_length force_reinit_new_goal_dist "
                "force_reinit_new_goal_angular feasibility_check_no_poses feasibility_check_lookahead_distance "
                "min_resolution_collision_check_angular no_inner_iterations no_outer_iterations optimization_activate "
                "optimization_verbose penalty_epsilon divergence_detection_enable "
                "divergence_detection_max_chi_squared optimization_activate control_look_ahead_poses "
                "prevent_look_ahead_poses_near_goal min_vel_theta is_footprint_dynamic use_gpu "
                "enable_homotopy_class_planning "
                "enable_multithreading simple_exploration max_number_classes max_number_plans_in_current_class "
                "selection_cost_hysteresis selection_prefer_initial_plan selection_obst_cost_scale "
                "selection_viapoint_cost_scale selection_alternative_time_cost selection_dropping_probability "
                "switching_blocking_period roadmap_graph_no_samples roadmap_graph_area_width "
                "roadmap_graph_area_length_scale h_signature_prescaler h_signature_threshold "
                "obstacle_heading_threshold "
                "obstacle_keypoint_offset viapoints_all_candidates delete_detours_backwards "
                "detours_orientation_tolerance length_start_orientation_vector "
                "max_ratio_detours_duration_best_duration "
                "max_samples shrink_horizon_backup shrink_horizon_min_duration odom_topic map_frame transform_tolerance"
            ),
            OTHER_COSTS: (
                "weight_max_vel_x weight_max_vel_theta weight_acc_lim_x weight_acc_lim_theta weight_kinematics_nh "
                "weight_kinematics_forward_drive weight_kinematics_turning_radius weight_optimaltime "
                "weight_shortest_path weight_obstacle weight_inflation weight_dynamic_obstacle "
                "weight_dynamic_obstacle_inflation weight_velocity_obstacle_ratio weight_viapoint "
                "weight_prefer_rotdir weight_adapt_factor obstacle_cost_exponent"
            ),
            "a planner keeps to a turning radius: lattice": (
                "min_turning_radius wheelbase cmd_angle_instead_rotvel"
            ),
            "obstacles are the cells of the local costmap": (
                "inflation_dist dynamic_obstacle_inflation_dist include_dynamic_obstacles include_costmap_obstacles "
                "costmap_obstacles_behind_robot_dist obstacle_poses_affected legacy_obstacle_association "
                "obstacle_association_force_inclusion_factor obstacle_association_cutoff_factor "
                "costmap_converter_plugin costmap_converter_spin_thread costmap_converter_rate "
                "obstacle_proximity_ratio_max_vel obstacle_proximity_lower_bound obstacle_proximity_upper_bound"
            ),
            "the outline of the robot is in global_costmap: footprint or robot_radius": (
                "footprint_model.type footprint_model.radius footprint_model.vertices footprint_model.line_start "
                "footprint_model.line_end footprint_model.front_offset footprint_model.front_radius "
                "footprint_model.rear_offset footprint_model.rear_radius"
            ),
            "Move Base watches progress": (
                "oscillation_recovery oscillation_recovery_min_duration oscillation_v_eps oscillation_omega_eps "
                "oscillation_filter_duration"
            ),
            SHOWN: "publish_feedback visualize_hc_graph visualize_with_time_as_z_axis_scale",
        },
        {
            "max_vel_x": above_zero, "max_vel_theta": above_zero, "acc_lim_x": above_zero, "acc_lim_theta": above_zero,
        },
    ),
    becomes="mppi",
)  # fmt: skip
