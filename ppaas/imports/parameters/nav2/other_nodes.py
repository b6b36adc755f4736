"""Parameters of docks, and of Nav2's nodes that a clone has none of: maps, routes, zones around the robot …"""

from ppaas.imports.parameters.nav2.tables import NodeTable, PluginGroup, PluginTable, rules_of
from ppaas.imports.parameters.rules import without_effect
from ppaas.imports.parameters.values import above_zero, number, whole

MONITOR = "keep the collision monitor on the robot, between the commands of the cloud and the base"
PUBLISH = "publish the map: ppaas map publish FILE.yaml"
MASK = "publish the mask as a map, and name it in keepout_filter.filter_mask or speed_filter.filter_mask"
DOCKS = "docks are zones of the map, of the kind 'dock'"
DOCK_TYPES = "write the detector of the dock into dock_types of docking_server"
DOCK_CONTROL = "the approach has its own controller"
ROUTES = "the clone plans on the map; lanes are part of the map: ppaas map lanes"
FOLLOWS = "follow_person follows people that the robot sees"
SMOOTHS = "a planner smooths its paths: smooth of a grid planner, smooth_path of lattice"
CYCLE = "the cloud starts the nodes, and moves them when a machine fails"
SIMULATES = "ppaas simulate simulates robots"
SHAPES = "draw the shapes as zones of the map"
COVERAGE = "paths of coverage are waypoints: send them to the waypoint follower"

_MAP_SERVER = without_effect(PUBLISH, "yaml_filename topic_name frame_id save_map_timeout")

_ZONE = PluginTable(
    "",
    without_effect(
        MONITOR,
        "type points polygon_sub_topic footprint_topic polygon_subscribe_transient_local radius action_type min_points "
        "max_points slowdown_ratio linear_limit angular_limit time_before_collision simulation_time_step visualize "
        "polygon_pub_topic enabled holonomic velocity_polygons sources_names linear_min linear_max theta_min theta_max "
        "direction_start_angle direction_end_angle steering_angle_min steering_angle_max wheelbase "
        "trigger_consecutive_points release_consecutive_points",
    ),
)

_SENSOR = PluginTable(
    "",
    without_effect(
        MONITOR,
        "type topic min_height max_height min_range max_range obstacles_angle sampling_distance enabled source_timeout "
        "transport_type use_global_height polygon_sampling_distance costmap_topic cost_threshold",
    ),
)

_MONITOR_GROUPS = (
    PluginGroup(("polygons",), untyped=_ZONE),
    PluginGroup(("observation_sources",), untyped=_SENSOR),
)

_DOCK_PLUGINS = tuple(
    PluginTable(
        plugin,
        without_effect(
            DOCK_TYPES,
            "staging_x_offset staging_yaw_offset use_battery_status use_external_detection_pose "
            "external_detection_timeout external_detection_translation_x external_detection_translation_y "
            "external_detection_rotation_yaw external_detection_rotation_pitch external_detection_rotation_roll "
            "filter_coef charging_threshold use_stall_detection stall_joint_names stall_velocity_threshold "
            "stall_effort_threshold docking_threshold dock_direction rotate_to_dock detector_service_name "
            "detector_service_timeout subscribe_toggle",
        ),
    )
    for plugin in ("opennav_docking::SimpleChargingDock", "opennav_docking::SimpleNonChargingDock")
)

_DOCKING = {
    "controller_frequency": above_zero, "initial_perception_timeout": above_zero, "wait_charge_timeout": above_zero,
    "dock_approach_timeout": above_zero, "max_retries": whole, "dock_prestaging_tolerance": number,
}  # fmt: skip

_DOCK_CONTROL = [
    "k_phi",
    "k_delta",
    "beta",
    "lambda",
    "v_linear_min",
    "v_linear_max",
    "v_angular_max",
    "slowdown_radius",
    "rotate_to_heading_angular_vel",
    "rotate_to_heading_max_angular_accel",
    "use_collision_detection",
    "costmap_topic",
    "footprint_topic",
    "transform_tolerance",
    "projection_time",
    "simulation_time_step",
    "simulation_step",
    "dock_collision_threshold",
    "deceleration_max",
]

_ROUTE_PARTS = (
    "weight costmap_topic max_cost use_maximum invalid_on_collision invalid_off_map check_resolution speed_tag "
    "time_tag max_vel penalty_tag semantic_classes semantic_key orientation_weight use_orientation_threshold "
    "orientation_tolerance speed_limit_topic rate max_collision_dist reroute_on_collision service_name"
)

_ROUTE_PLUGINS = tuple(
    PluginTable(f"nav2_route::{name}", without_effect(ROUTES, _ROUTE_PARTS))
    for name in (
        "GeoJsonGraphFileLoader", "DistanceScorer", "DynamicEdgesScorer", "CostmapScorer", "TimeScorer",
        "PenaltyScorer", "SemanticScorer", "StartPoseOrientationScorer", "GoalPoseOrientationScorer",
        "AdjustSpeedLimit", "CollisionMonitor", "TimeMarker", "ReroutingService", "TriggerEvent",
        "GeoJsonGraphFileSaver",
    )
)  # fmt: skip

_SMOOTHERS = tuple(
    PluginTable(plugin, without_effect(SMOOTHS, names))
    for plugin, names in {
        "nav2_smoother::SimpleSmoother": (
            "tolerance max_its w_data w_smooth do_refinement refinement_num enforce_path_inversion"
        ),
        "nav2_smoother::SavitzkyGolaySmoother": (
            "do_refinement refinement_num enforce_path_inversion window_size poly_order"
        ),
        "nav2_constrained_smoother::ConstrainedSmoother": (
            "reversing_enabled path_downsampling_factor path_upsampling_factor keep_start_orientation "
            "keep_goal_orientation minimum_turning_radius w_curve w_dist w_smooth w_cost w_cost_cusp_multiplier "
            "cusp_zone_length cost_check_points optimizer.max_iterations optimizer.debug_optimizer "
            "optimizer.linear_solver_type optimizer.fn_tol optimizer.gradient_tol optimizer.param_tol"
        ),
    }.items()
)

OTHER_NODES = (
    NodeTable("map_server", _MAP_SERVER),
    NodeTable(
        "map_saver",
        without_effect(
            "a robot that makes a map publishes it: ppaas robot map",
            "save_map_timeout free_thresh_default occupied_thresh_default map_subscribe_transient_local",
        ),
    ),
    NodeTable(
        "filter_mask_server",
        without_effect(MASK, "yaml_filename topic_name frame_id"),
        also=("keepout_filter_mask_server", "speed_filter_mask_server", "costmap_filter_mask_server"),
    ),
    NodeTable(
        "collision_monitor",
        without_effect(
            MONITOR,
            "enabled base_frame_id odom_frame_id cmd_vel_in_topic cmd_vel_out_topic state_topic transform_tolerance "
            "source_timeout base_shift_correction stop_pub_timeout toggle_service_name",
        ),
        _MONITOR_GROUPS,
    ),
    NodeTable(
        "collision_detector",
        without_effect(
            MONITOR,
            "enabled base_frame_id odom_frame_id frequency state_topic transform_tolerance source_timeout "
            "base_shift_correction",
        ),
        _MONITOR_GROUPS,
    ),
    NodeTable(
        "docking_server",
        rules_of(
            "docking_server",
            " ".join(_DOCKING),
            {},
            {
                DOCK_CONTROL: (
                    "rotate_to_dock_timeout undock_linear_tolerance undock_angular_tolerance "
                    "rotation_angular_tolerance " + " ".join(f"controller.{name}" for name in _DOCK_CONTROL)
                ),
                "the robot names its frames and topics": "base_frame fixed_frame odom_topic odom_duration",
                DOCK_TYPES: "dock_backwards",
                DOCKS: "dock_database",
                CYCLE: "navigator_bt_xml",
            },
            _DOCKING,
        ),
        (
            PluginGroup(("dock_plugins",), _DOCK_PLUGINS),
            PluginGroup(("docks",), untyped=PluginTable("", without_effect(DOCKS, "type frame pose id"))),
        ),
    ),
    NodeTable(
        "following_server",
        without_effect(
            FOLLOWS,
            "controller_frequency detection_timeout rotate_to_object_timeout static_object_timeout linear_tolerance "
            "angular_tolerance max_retries base_frame fixed_frame filter_coef desired_distance skip_orientation "
            "search_by_rotating search_angle odom_topic odom_duration transform_tolerance "
            + " ".join(f"controller.{name}" for name in _DOCK_CONTROL),
        ),
    ),
    NodeTable(
        "route_server",
        without_effect(
            ROUTES,
            "base_frame route_frame global_frame path_density max_iterations max_planning_time smooth_corners "
            "smoothing_corners smoothing_radius costmap_topic tracker_update_rate aggregate_blocked_ids "
            "boundary_radius_to_achieve_node radius_to_achieve_node max_dist_from_edge max_prune_dist_from_edge "
            "min_prune_dist_from_goal min_prune_dist_from_start prune_goal enable_nn_search max_nn_search_iterations "
            "num_nearest_nodes graph_filepath graph_file_loader.plugin use_feedback_operations",
        ),
        (
            PluginGroup(("graph_file_loader",), _ROUTE_PLUGINS),
            PluginGroup(("edge_cost_functions",), _ROUTE_PLUGINS),
            PluginGroup(("operations",), _ROUTE_PLUGINS),
        ),
    ),
    NodeTable(
        "smoother_server",
        without_effect(
            SMOOTHS,
            "costmap_topic footprint_topic transform_tolerance odom_topic robot_base_frame robot_frame_id "
            "local_costmap_topic global_costmap_topic",
        ),
        (PluginGroup(("smoother_plugins",), _SMOOTHERS, {"simple_smoother": _SMOOTHERS[0].plugin}),),
    ),
    NodeTable(
        "vector_object_server",
        without_effect(
            SHAPES,
            "map_topic global_frame_id resolution default_value overlay_type update_frequency transform_tolerance",
        ),
        (
            PluginGroup(
                ("shapes",),
                untyped=PluginTable(
                    "", without_effect(SHAPES, "type uuid frame_id value points closed center radius fill")
                ),
            ),
        ),
    ),
    NodeTable(
        "coverage_server",
        without_effect(
            COVERAGE,
            "robot_width operation_width min_turning_radius linear_curv_change order_ids "
            "coordinates_in_cartesian_frame "
            "default_headland_type default_headland_width default_swath_type default_swath_angle_type "
            "default_swath_angle default_allow_overlap default_step_angle default_swath_objective "
            "default_route_type default_spiral_n default_custom_order default_path_type "
            "default_path_continuity_type default_turn_point_distance rotate_headland",
        ),
        also=("row_coverage_server",),
    ),
    NodeTable(
        "lifecycle_manager",
        without_effect(
            CYCLE,
            "node_names autostart attempt_respawn_reconnection bond_respawn_max_duration parallel_state_transitions "
            "service_timeout",
        ),
        also=(
            "lifecycle_manager_navigation", "lifecycle_manager_localization", "lifecycle_manager_slam",
            "lifecycle_manager_map_server", "lifecycle_manager_costmap_filters", "lifecycle_manager_keepout_zone",
            "lifecycle_manager_speed_zone",
        ),
    ),
    NodeTable(
        "loopback_simulator",
        without_effect(
            SIMULATES,
            "base_frame_id odom_frame_id map_frame_id scan_frame_id update_duration scan_publish_dur "
            "publish_map_odom_tf publish_scan "
            "publish_clock scan_range_min scan_range_max scan_angle_min scan_angle_max scan_angle_increment "
            "scan_use_inf scan_noise_std scan_num enable_stamped_cmd_vel speed_factor odom_publish_dur",
        ),
    ),
)  # fmt: skip

FILTER_INFO = without_effect(MASK, "filter_info_topic mask_topic")
"""Parameters of the servers of filter infos that have no effect; the others depend on their type."""

FILTER_INFO_SERVERS = (
    "costmap_filter_info_server", "keepout_costmap_filter_info_server", "speed_costmap_filter_info_server",
)  # fmt: skip
