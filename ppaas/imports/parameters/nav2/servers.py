"""Parameters of the nodes that plan, drive and recover, and of their plug-ins that are no controllers or planners."""

from ppaas.imports.parameters.nav2.controllers import DWB, MPPI, TEB
from ppaas.imports.parameters.nav2.planners import PLANNERS
from ppaas.imports.parameters.nav2.pursuit import GRACEFUL, PURE_PURSUIT, SHIM, VECTOR_PURSUIT
from ppaas.imports.parameters.nav2.reasons import TRANSFORMS, TYPES, WHOLE_PATH
from ppaas.imports.parameters.nav2.tables import NodeTable, PluginGroup, PluginTable, rules_of
from ppaas.imports.parameters.rules import without_effect
from ppaas.imports.parameters.values import above_zero, flag, number, whole

ONE_TOPIC = "the topics of a robot have fixed names"
BY_ACTION = "the clone drives by its own state machine; --bt-xml FILE takes a tree's recoveries and rate"
FRAMES = "amcl names the frames"

CONTROLLER = "controller"
"""Place of the robot's local planner in the rules of goal checkers, which the importer replaces by its name."""

PROGRESS_CHECKERS = (
    PluginTable(
        "nav2_controller::SimpleProgressChecker",
        rules_of(
            "move_base",
            converted={
                "required_movement_radius": ("oscillation_distance", number),
                "movement_time_allowance": ("oscillation_timeout", number),
            },
        ),
    ),
    PluginTable(
        "nav2_controller::PoseProgressChecker",
        rules_of(
            "move_base",
            converted={
                "required_movement_radius": ("oscillation_distance", number),
                "movement_time_allowance": ("oscillation_timeout", number),
            },
            no_effect={"turns are no progress": "required_movement_angle"},
        ),
    ),
)

_LATCHED = {
    "the robot turns at the goal, and is there when both tolerances hold": (
        "stateful symmetric_yaw_tolerance path_length_tolerance"
    )
}
_BOTH = {"xy_goal_tolerance": number, "yaw_goal_tolerance": number}

GOAL_CHECKERS = (
    PluginTable(
        "nav2_controller::SimpleGoalChecker", rules_of(CONTROLLER, " ".join(_BOTH), {}, _LATCHED, _BOTH)
    ),
    PluginTable(
        "nav2_controller::StoppedGoalChecker",
        rules_of(
            CONTROLLER,
            " ".join(_BOTH),
            {
                "trans_stopped_velocity": ("trans_stopped_vel", number),
                "rot_stopped_velocity": ("rot_stopped_vel", number),
            },
            _LATCHED,
            _BOTH,
        ),
    ),
    PluginTable(
        "nav2_controller::PositionGoalChecker",
        rules_of(
            CONTROLLER,
            "xy_goal_tolerance",
            {},
            {**_LATCHED, "the robot turns to the heading of each goal": "yaw_goal_tolerance"},
            {"xy_goal_tolerance": number},
        ),
    ),
    PluginTable(
        "nav2_controller::AxisGoalChecker",
        rules_of(
            CONTROLLER,
            converted={"along_path_tolerance": ("xy_goal_tolerance", number)},
            no_effect={
                "one tolerance holds in all directions": (
                    "cross_track_tolerance direction_estimation_distance is_overshoot_valid"
                ),
                "the whole path is driven": "path_length_tolerance",
            },
        ),
    ),
    PluginTable(
        "nav2_controller::AdaptiveToleranceGoalChecker",
        rules_of(
            CONTROLLER,
            "yaw_goal_tolerance",
            {
                "fine_xy_goal_tolerance": ("xy_goal_tolerance", number),
                "trans_stopped_velocity": ("trans_stopped_vel", number),
                "rot_stopped_velocity": ("rot_stopped_vel", number),
            },
            {**_LATCHED, "the fine tolerance counts": "coarse_xy_goal_tolerance required_stagnation_cycles"},
            {"yaw_goal_tolerance": number},
        ),
    ),
)  # fmt: skip

_PATH_HANDLER = (
    "reject_unit_path prune_distance max_robot_pose_search_dist enforce_path_inversion enforce_path_rotation "
    "minimum_rotation_angle inversion_xy_tolerance inversion_yaw_tolerance transform_tolerance "
    "interpolate_curvature_after_goal"
)

PATH_HANDLERS = (PluginTable("nav2_controller::FeasiblePathHandler", without_effect(WHOLE_PATH, _PATH_HANDLER)),)

CONTROLLER_SERVER = NodeTable(
    "controller_server",
    rules_of(
        "move_base",
        "controller_frequency",
        {"failure_tolerance": ("controller_patience", lambda value: None if number(value) < 0.0 else number(value))},
        {
            "odometry is used as it is": (
                "min_x_velocity_threshold min_y_velocity_threshold min_theta_velocity_threshold odom_duration"
            ),
            ONE_TOPIC: "speed_limit_topic odom_topic",
            "a robot without commands is stopped": "publish_zero_velocity",
            "the local costmap is current in each cycle": "costmap_update_timeout",
            WHOLE_PATH: f"{_PATH_HANDLER} search_window",
            TYPES: "controller_plugin_types",
            "each section names its plug-in": (
                "goal_checker_plugin_types progress_checker_plugin_types goal_checker_plugin_id default_goal_checker"
            ),
        },
        {"controller_frequency": number},
    ),
    (
        PluginGroup(
            ("controller_plugins", "controller_plugin_ids"),
            (DWB, MPPI, PURE_PURSUIT, GRACEFUL, VECTOR_PURSUIT, TEB, SHIM),
            {"FollowPath": DWB.plugin},
            only_first=True,
        ),
        PluginGroup(
            ("progress_checker_plugins", "progress_checker_plugin"),
            PROGRESS_CHECKERS,
            {"progress_checker": PROGRESS_CHECKERS[0].plugin},
            only_first=True,
        ),
        PluginGroup(
            ("goal_checker_plugins", "goal_checker_plugin"),
            GOAL_CHECKERS,
            {"goal_checker": GOAL_CHECKERS[0].plugin},
            only_first=True,
        ),
        PluginGroup(
            ("path_handler_plugins", "path_handler_plugin"),
            PATH_HANDLERS,
            {"PathHandler": PATH_HANDLERS[0].plugin, "path_handler": PATH_HANDLERS[0].plugin},
        ),
    ),
)

PLANNER_SERVER = NodeTable(
    "planner_server",
    without_effect(
        "a tree's RateController sets the rate: planner_frequency of move_base",
        "expected_planner_frequency",
    )
    | without_effect("plans are made on the current costmap", "costmap_update_timeout")
    | without_effect(TYPES, "planner_plugin_types")
    | without_effect("a path leads to the goal, or there is none", "allow_partial_planning partial_plan_tolerance"),
    (PluginGroup(("planner_plugins", "planner_plugin_ids"), PLANNERS, {"GridBased": PLANNERS[0].plugin}),),
)

# -- behaviors ---------------------------------------------------------------------------------------------------------

_SPIN_RULES = rules_of(
    "spin",
    "max_rotational_vel",
    {
        "min_rotational_vel": ("min_in_place_rotational_vel", number),
        "rotational_acc_lim": ("acc_lim_th", above_zero),
    },
    {"the outline of the robot is checked ahead of the turn": "simulate_ahead_time"},
    {"max_rotational_vel": above_zero},
)

_BACKUP_RULES = rules_of(
    "backup",
    "simulate_ahead_time",
    {},
    {"the robot backs up at one speed": "acceleration_limit deceleration_limit minimum_speed"},
    {"simulate_ahead_time": number},
)

_TELEOP = "projection_time simulation_time_step cmd_vel_teleop"

BEHAVIORS = (
    PluginTable("nav2_behaviors::Spin", _SPIN_RULES, becomes="rotate_recovery"),
    PluginTable("nav2_behaviors::BackUp", _BACKUP_RULES, becomes="back_up"),
    PluginTable("nav2_behaviors::Wait", {}, becomes="wait"),
    PluginTable("nav2_recoveries::Spin", _SPIN_RULES, becomes="rotate_recovery"),
    PluginTable("nav2_recoveries::BackUp", _BACKUP_RULES, becomes="back_up"),
    PluginTable("nav2_recoveries::Wait", {}, becomes="wait"),
    PluginTable(
        "nav2_behaviors::DriveOnHeading",
        without_effect(
            "no recovery drives ahead", "simulate_ahead_time acceleration_limit deceleration_limit minimum_speed"
        ),
    ),
    PluginTable(
        "nav2_behaviors::AssistedTeleop", without_effect("ppaas robot drive has its own parameters: teleop", _TELEOP)
    ),
)

BEHAVIOR_SERVER = NodeTable(
    "behavior_server",
    _BACKUP_RULES
    | {name: rule for name, rule in _SPIN_RULES.items() if name != "simulate_ahead_time"}
    | without_effect(
        "the clone has one costmap and one footprint",
        "costmap_topic footprint_topic local_costmap_topic global_costmap_topic local_footprint_topic "
        "global_footprint_topic",
    )
    | without_effect("recoveries run at controller_frequency", "cycle_frequency")
    | without_effect(FRAMES, "global_frame local_frame robot_base_frame")
    | without_effect(TYPES, "plugin_types")
    | without_effect(TRANSFORMS, "transform_tolerance transform_timeout")
    | without_effect("ppaas robot drive has its own parameters: teleop", _TELEOP),
    (
        PluginGroup(
            ("behavior_plugins", "recovery_plugins", "plugin_names"),
            BEHAVIORS,
            {
                "spin": "nav2_behaviors::Spin",
                "backup": "nav2_behaviors::BackUp",
                "drive_on_heading": "nav2_behaviors::DriveOnHeading",
                "wait": "nav2_behaviors::Wait",
            },
        ),
    ),
    also=("recoveries_server", "behaviors_server"),
)

# -- navigator, smoother of velocities, waypoints ----------------------------------------------------------------------

_NAVIGATOR = without_effect(
    BY_ACTION,
    "enable_groot_monitoring groot_server_port groot_zmq_publisher_port groot_zmq_server_port search_window "
    "goal_blackboard_id goals_blackboard_id "
    "path_blackboard_id waypoint_statuses_blackboard_id max_viapoints_search_dist field_file_blackboard_id "
    "field_polygon_blackboard_id polygon_frame_blackboard_id",
)

BT_NAVIGATOR = NodeTable(
    "bt_navigator",
    _NAVIGATOR
    | without_effect(
        BY_ACTION,
        "default_nav_to_pose_bt_xml default_nav_through_poses_bt_xml default_bt_xml_filename default_bt_xml "
        "bt_xml_filename bt_search_directories always_reload_bt_xml always_use_latest_bt_xml plugin_lib_names "
        "bt_loop_duration filter_duration default_server_timeout default_cancel_timeout wait_for_service_timeout "
        "error_code_name_prefixes error_code_names error_code_id_names transform_tolerance "
        "enable_groot_monitoring_to_file "
        "goal_updater_topic goals_updater_topic bt_log_idle_transitions",
    )
    | without_effect(FRAMES, "global_frame robot_base_frame")
    | without_effect(ONE_TOPIC, "odom_topic"),
    (
        PluginGroup(
            ("navigators",),
            tuple(
                PluginTable(name, _NAVIGATOR)
                for name in (
                    "nav2_bt_navigator::NavigateToPoseNavigator",
                    "nav2_bt_navigator::NavigateThroughPosesNavigator",
                    "opennav_coverage_navigator::CoverageNavigator",
                )
            ),
            {
                "navigate_to_pose": "nav2_bt_navigator::NavigateToPoseNavigator",
                "navigate_through_poses": "nav2_bt_navigator::NavigateThroughPosesNavigator",
            },
        ),
    ),
    also=("navigator",),
)

VELOCITY_SMOOTHER = NodeTable(
    "velocity_smoother",
    without_effect("the base brakes as it accelerates", "max_decel")
    | without_effect("a robot that gets no command stops by itself", "velocity_timeout stop_after_timeout")
    | without_effect(
        "commands change within the limits of acceleration, cycle by cycle",
        "smoothing_frequency scale_velocities feedback odom_topic odom_duration use_realtime_priority "
        "stamp_smoothed_velocity_with_smoothing_time",
    ),
)
"""Its limits are lists, and are not here: see ``limits.SMOOTHED``."""

_TASK_NONE = "the robot drives on: call its own services at waypoints"

WAYPOINT_FOLLOWER = NodeTable(
    "waypoint_follower",
    rules_of(
        "waypoint_follower",
        "stop_on_failure loop_rate",
        {},
        {"waypoints are in the frame of the map": "global_frame_id"},
        {"stop_on_failure": flag, "loop_rate": number},
    ),
    (
        PluginGroup(
            ("waypoint_task_executor_plugin",),
            (
                PluginTable(
                    "nav2_waypoint_follower::WaitAtWaypoint",
                    rules_of(
                        "waypoint_follower",
                        "waypoint_pause_duration",
                        {},
                        {"a pause of 0 waits at none": "enabled"},
                        {"waypoint_pause_duration": whole},
                    ),
                ),
                PluginTable(
                    "nav2_waypoint_follower::PhotoAtWaypoint",
                    without_effect(_TASK_NONE, "enabled camera_image_topic_name image_topic save_dir image_format"),
                ),
                PluginTable(
                    "nav2_waypoint_follower::InputAtWaypoint", without_effect(_TASK_NONE, "enabled timeout input_topic")
                ),
            ),
            {"wait_at_waypoint": "nav2_waypoint_follower::WaitAtWaypoint"},
            only_first=True,
        ),
    ),
)
