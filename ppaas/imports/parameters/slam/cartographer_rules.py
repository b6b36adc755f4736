"""Rules for the options of cartographer and of its node: what maps on a robot that makes a map by ``grid_slam``."""

from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, without_effect
from ppaas.imports.parameters.slam.slam_toolbox_rules import LEAST_TRAVEL, STEP
from ppaas.imports.parameters.values import at_least, frame

_SLAM = "parameters.grid_slam."
_AMCL = "parameters.amcl."

_TOPICS = "the topics are those of the robot: 'scan' and 'odom'"
_RATES = "poses and maps are published with the scans"
_SAMPLING = "all messages are used"
_SOLVER = "the pose graph is solved by our own solver"
_MATCHER = "scans are aligned with key frames by their lines; there is no such term"
_SUBMAPS = "submaps are 3 m of the drive"
_IMU = "the robot has no IMU here: its odometry has the heading"
_THREADS = "the container has the cores of the robot file"
_LANDMARKS = "neither landmarks nor satellites are used"
_CLOSURES = "a closure is checked by the points that agree"


NODE: ParameterRules = {
    "map_frame": ParameterRule(_SLAM + "map_frame", convert=frame),
    "odom_frame": ParameterRule(text="odometry names its frames itself"),
    "tracking_frame": ParameterRule(text="a robot is driven in base_link, to which its transforms move all scans"),
    "published_frame": ParameterRule(text="the transform is that from the map to the frame of the odometry"),
    "pose_publish_period_sec": ParameterRule(_SLAM + "transform_publish_period"),
    "publish_to_tf": ParameterRule(text="the transform is published; set transform_publish_period to 0 for none"),
    "submap_publish_period_sec": ParameterRule(_SLAM + "map_update_interval", "at least 1 s", at_least(1.0)),
    **without_effect(
        _TOPICS, "num_laser_scans", "num_multi_echo_laser_scans", "num_subdivisions_per_laser_scan", "num_point_clouds",
        "use_laser_scan", "use_multi_echo_laser_scan", "use_odometry", "use_odometry_data", "expect_odometry_data",
        "use_multi_echo_laser_scan_2d", "num_lasers_3d", "use_horizontal_laser", "use_horizontal_multi_echo_laser",
        "expect_horizontal_laser", "expect_horizontal_multi_echo_laser",
    ),
    "laser_min_range": ParameterRule(_SLAM + "minimum_laser_range"),
    "laser_max_range": ParameterRule(_SLAM + "max_laser_range"),
    "horizontal_laser_min_range": ParameterRule(_SLAM + "minimum_laser_range"),
    "horizontal_laser_max_range": ParameterRule(_SLAM + "max_laser_range"),
    **without_effect(
        "beams without echo clear nothing; inf_is_valid of grid_slam does", "laser_missing_echo_ray_length",
        "horizontal_laser_missing_echo_ray_length",
    ),
    **without_effect(_RATES, "trajectory_publish_period_sec", "publish_occupancy_grid", "publish_tracked_pose"),
    **without_effect(
        _SAMPLING, "rangefinder_sampling_ratio", "odometry_sampling_ratio", "fixed_frame_pose_sampling_ratio",
        "imu_sampling_ratio", "landmarks_sampling_ratio",
    ),
    **without_effect(_LANDMARKS, "use_nav_sat", "use_landmarks", "nav_sat_use_predefined_enu_frame"),
    "provide_odom_frame": ParameterRule(text="odometry names its frames itself"),
    "use_pose_extrapolator": ParameterRule(text="poses between scans follow the odometry"),
    "publish_frame_projected_to_2d": ParameterRule(text="poses are in the plane"),
    "lookup_transform_timeout_sec": ParameterRule(text="scans wait up to 3 s for the transform of their frame"),
    "lookup_transform_timeout": ParameterRule(text="scans wait up to 3 s for the transform of their frame"),
}  # fmt: skip
"""Options of the node, of which those of 2016 have other names."""

TRAJECTORY_2D: ParameterRules = {
    "min_range": ParameterRule(_SLAM + "minimum_laser_range"),
    "max_range": ParameterRule(_SLAM + "max_laser_range"),
    "laser_min_range": ParameterRule(_SLAM + "minimum_laser_range"),
    "laser_max_range": ParameterRule(_SLAM + "max_laser_range"),
    "motion_filter.max_distance_meters": ParameterRule(
        _SLAM + "minimum_travel_distance", STEP, at_least(LEAST_TRAVEL)
    ),
    "motion_filter.max_angle_radians": ParameterRule(
        _SLAM + "minimum_travel_heading", STEP, at_least(LEAST_TRAVEL)
    ),
    "motion_filter.max_time_seconds": ParameterRule(text="a robot that stands adds nothing to its map"),
    "submaps.resolution": ParameterRule(_SLAM + "resolution"),
    "submaps.grid_options_2d.resolution": ParameterRule(_SLAM + "resolution"),
    "missing_data_ray_length": ParameterRule(text="beams without echo clear nothing; inf_is_valid of grid_slam does"),
    "laser_missing_echo_ray_length": ParameterRule(
        text="beams without echo clear nothing; inf_is_valid of grid_slam does"
    ),
    **without_effect(_IMU, "use_imu_data", "imu_gravity_time_constant", "pose_extrapolator", "pose_tracker"),
    **without_effect(
        "lasers are projected to the ground by their transforms", "min_z", "max_z", "laser_min_z", "laser_max_z",
        "horizontal_laser_min_z", "horizontal_laser_max_z",
    ),
    **without_effect(
        "the beams of each scan are used as they come", "num_accumulated_range_data", "voxel_filter_size",
        "laser_voxel_filter_size", "horizontal_laser_voxel_filter_size", "adaptive_voxel_filter",
        "loop_closure_adaptive_voxel_filter", "num_odometry_states", "scans_per_accumulation",
    ),
    **without_effect(
        _MATCHER, "use_online_correlative_scan_matching", "real_time_correlative_scan_matcher", "ceres_scan_matcher",
    ),
    **without_effect(
        _SUBMAPS, "submaps.num_range_data", "submaps.half_length", "submaps.num_laser_fans",
        "submaps.output_debug_images",
    ),
    **without_effect(
        "cells are drawn by min_pass_through and occupancy_threshold", "submaps.range_data_inserter",
        "submaps.laser_fan_inserter", "submaps.grid_options_2d.grid_type",
    ),
}  # fmt: skip
"""Options of the two-dimensional trajectory builder."""

POSE_GRAPH: ParameterRules = {
    "constraint_builder.max_constraint_distance": ParameterRule(_SLAM + "loop_search_maximum_distance"),
    **without_effect(
        _CLOSURES,
        *(
            f"constraint_builder.{name}"
            for name in (
                "adaptive_voxel_filter", "sampling_ratio", "min_score", "global_localization_min_score",
                "lower_covariance_eigenvalue_bound", "loop_closure_translation_weight", "loop_closure_rotation_weight",
                "log_matches", "fast_correlative_scan_matcher", "ceres_scan_matcher",
                "fast_correlative_scan_matcher_3d", "ceres_scan_matcher_3d", "high_resolution_adaptive_voxel_filter",
                "low_resolution_adaptive_voxel_filter", "min_low_resolution_score",
                "constant_local_submap_covariance",
            )
        ),
    ),
    **without_effect(
        _SOLVER, "optimize_every_n_nodes", "optimize_every_n_scans", "optimization_problem",
        "matcher_translation_weight", "matcher_rotation_weight", "max_num_final_iterations", "log_residual_histograms",
    ),
    **without_effect(
        "places are searched as the uncertainty of the pose grows", "global_sampling_ratio",
        "global_constraint_search_after_n_seconds",
    ),
    "overlapping_submaps_trimmer_2d": ParameterRule(text="grid_slam removes key frames with mode 'lifelong'"),
}  # fmt: skip
"""Options of the pose graph. ``optimize_every_n_nodes`` of 0 means no closures, and is translated apart."""

MAP_BUILDER: ParameterRules = {
    "use_trajectory_builder_2d": ParameterRule(text="grid_slam makes maps of the plane"),
    "num_background_threads": ParameterRule(text=_THREADS),
    "collate_by_trajectory": ParameterRule(text="each robot has a map of its own until maps are joined"),
}
"""Options of the map builder. ``use_trajectory_builder_3d`` is translated apart."""

TRAJECTORY: ParameterRules = {
    "collate_fixed_frame": ParameterRule(text=_LANDMARKS),
    "collate_landmarks": ParameterRule(text=_LANDMARKS),
    "pure_localization": ParameterRule(text="see pure_localization_trimmer"),
    "pure_localization_trimmer": ParameterRule(text="see pure_localization"),
    "expect_imu_data": ParameterRule(text=_IMU),
}
"""Options of all trajectories. Pure localization is translated apart."""

IN_SPACE = "grid_slam makes maps of the plane; octomap_server makes those in space"
"""Reason for which options of the three-dimensional trajectory builder have no effect."""

ON_A_MAP = {
    _SLAM + "map_frame": _AMCL + "global_frame_id",
    _SLAM + "max_laser_range": _AMCL + "laser_max_range",
    _SLAM + "minimum_laser_range": _AMCL + "laser_min_range",
    _SLAM + "minimum_travel_distance": _AMCL + "update_min_d",
    _SLAM + "minimum_travel_heading": _AMCL + "update_min_a",
}
"""Places of a robot that is localized on a published map, by those of one that makes a map."""
