"""Rules for the parameters of slam_toolbox: of a robot that makes a map, and of one that is localized by it."""

from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, same, without_effect
from ppaas.imports.parameters.values import at_least, frame, within
from ppaas.mapping.parameters import MAX_SCAN_BUFFER

_SLAM = "parameters.grid_slam."
_AMCL = "parameters.amcl."

_SOLVER = "the pose graph is solved by our own solver"
_MATCHER = "scans are aligned with key frames by their lines; there is no such term"
_LINKS = "each scan is aligned with the last key frames, and so linked"
_SEARCH = "the window and its steps follow from the uncertainty of the pose"
_TOPIC = "the bridge of the robot, or its client, sends its scans as 'scan'"
_DISK = "a container keeps no files; publish the map: ppaas robot map ROBOT --publish MAP"
_LAUNCH = "it belongs to the life of a node of ROS"
_DECAY = "key frames are removed by what later ones show, without scores that decay"
_COVARIANCE = "the covariance of the pose is published as it is"
_ONE_MODE = "a robot maps as its scans come"
_HELD = "a robot on a published map makes none"

LEAST_TRAVEL = 0.05
"""Least distance and turn between key frames [m, rad]."""

STEP = f"at least {LEAST_TRAVEL}: a robot that stands would add a key frame with each scan"
"""Reason of that."""

FRAMES = f"at most {MAX_SCAN_BUFFER} key frames"


_NEITHER: ParameterRules = {
    **without_effect(
        _SOLVER, "solver_plugin", "ceres_linear_solver", "ceres_preconditioner", "ceres_trust_strategy",
        "ceres_dogleg_type", "ceres_loss_function",
    ),
    **without_effect(
        _MATCHER, "use_scan_barycenter", "distance_variance_penalty", "angle_variance_penalty",
        "fine_search_angle_offset", "minimum_angle_penalty", "minimum_distance_penalty", "use_response_expansion",
    ),
    **without_effect(
        _LINKS, "link_match_minimum_response_fine", "link_scan_maximum_distance", "scan_buffer_maximum_scan_distance",
    ),
    **without_effect(
        _SEARCH, "coarse_search_angle_offset", "coarse_angle_resolution", "loop_search_space_dimension",
        "correlation_search_space_dimension", "correlation_search_space_resolution",
        "correlation_search_space_smear_deviation",
    ),
    **without_effect(_TOPIC, "scan_topic", "scan_queue_size", "scan_share_topic", "laser_frame", "odom_topic"),
    **without_effect(_DISK, "use_map_saver", "stack_size_to_use", "map_name"),
    **without_effect(_LAUNCH, "debug_logging", "tf_buffer_duration", "use_lifecycle_manager", "restamp_tf"),
    **without_effect(_COVARIANCE, "position_covariance_scale", "yaw_covariance_scale"),
    **without_effect(
        _ONE_MODE, "sychronous", "synchronous", "online", "publish_occupancy_map",
        "check_min_dist_and_heading_precisely",
    ),
    "use_scan_matching": ParameterRule(text="scans are always aligned: the odometry alone makes no map"),
    "inverted_laser": ParameterRule(text="a laser that is upside down is known by its transform"),
    "enable_interactive_mode": ParameterRule(text="key frames are not moved by hand"),
    "interactive_mode": ParameterRule(text="key frames are not moved by hand"),
    "loop_match_maximum_variance_coarse": ParameterRule(text="a closure is checked by the points that agree"),
    "loop_match_minimum_response_fine": ParameterRule(text="a closure is checked by the points that agree"),
    "loop_match_minimum_chain_size": ParameterRule(
        text="a submap is 3 m long, whatever its key frames; 3 of its scans have to agree"
    ),
}  # fmt: skip
"""Parameters without effect in either mode."""

_DECAYING = (
    "lifelong_search_use_tree", "lifelong_minimum_score", "lifelong_node_removal_score", "lifelong_overlap_score_scale",
    "lifelong_constraint_multiplier", "lifelong_nearby_penalty", "lifelong_candidates_scale",
)  # fmt: skip

MAPPING_RULES: ParameterRules = {
    **_NEITHER,
    **without_effect(_DECAY, *_DECAYING),
    **same(
        _SLAM,
        "resolution",
        "max_laser_range",
        "minimum_time_interval",
        "map_update_interval",
        "transform_publish_period",
        "transform_timeout",
        "min_pass_through",
        "occupancy_threshold",
        "do_loop_closing",
        "paused_new_measurements",
        "correlation_search_space_smear_deviation",
        "loop_search_maximum_distance",
        "lifelong_iou_match",
        "loop_search_space_resolution",
        "loop_search_space_smear_deviation",
        "loop_match_minimum_response_coarse",
    ),
    **same(_SLAM, "odom_frame", "map_frame", "base_frame", convert=frame),
    "throttle_scans": ParameterRule(_SLAM + "throttle_scans", "at least 1", at_least(1, int)),
    "minimum_travel_distance": ParameterRule(_SLAM + "minimum_travel_distance", STEP, at_least(LEAST_TRAVEL)),
    "minimum_travel_heading": ParameterRule(_SLAM + "minimum_travel_heading", STEP, at_least(LEAST_TRAVEL)),
    "min_laser_range": ParameterRule(_SLAM + "minimum_laser_range"),
    "scan_buffer_size": ParameterRule(_SLAM + "scan_buffer_size", FRAMES, within(1, MAX_SCAN_BUFFER)),
}
"""Rules of a robot that makes a map. ``mode``, ``map_file_name`` and the start are translated together."""

LOCALIZATION_RULES: ParameterRules = {
    **_NEITHER,
    **without_effect(_DECAY, *_DECAYING, "lifelong_iou_match"),
    **without_effect(
        _HELD, "resolution", "map_update_interval", "min_pass_through", "occupancy_threshold", "do_loop_closing",
        "paused_new_measurements", "scan_buffer_size", "loop_search_maximum_distance", "loop_search_space_resolution",
        "loop_search_space_smear_deviation", "loop_match_minimum_response_coarse",
    ),
    **without_effect(
        "particles are weighed by all scans that come after the robot has moved", "throttle_scans",
        "minimum_time_interval", "transform_publish_period",
    ),
    "odom_frame": ParameterRule(_AMCL + "odom_frame_id", convert=frame),
    "map_frame": ParameterRule(_AMCL + "global_frame_id", convert=frame),
    "base_frame": ParameterRule(_AMCL + "base_frame_id", convert=frame),
    "minimum_travel_distance": ParameterRule(_AMCL + "update_min_d"),
    "minimum_travel_heading": ParameterRule(_AMCL + "update_min_a"),
    "max_laser_range": ParameterRule(_AMCL + "laser_max_range"),
    "min_laser_range": ParameterRule(_AMCL + "laser_min_range"),
    "transform_timeout": ParameterRule(_AMCL + "transform_tolerance"),
}  # fmt: skip
"""Rules of a robot that is localized on a published map, by amcl."""

TOGETHER = ("mode", "map_file_name", "map_start_pose", "map_start_at_dock")
"""Parameters that are translated together."""
