"""Rules for the parameters of amcl, of ROS 1 and of Nav2, as parameters of our node of that name."""

from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, renamed, same, without_effect
from ppaas.imports.parameters.values import flag, frame, number, one_of, whole

_AMCL = "parameters.amcl."

LASER_MODELS = {name: name for name in ("likelihood_field", "likelihood_field_prob", "beam")}
ODOMETRY_MODELS = {name: name for name in ("diff", "omni", "diff-corrected", "omni-corrected")}

MOTION_MODELS = {
    "nav2_amcl::DifferentialMotionModel": "diff-corrected",
    "nav2_amcl::OmniMotionModel": "omni-corrected",
    "differential": "diff-corrected",
    "omnidirectional": "omni-corrected",
}
"""Motion models of Nav2; before Humble they had short names. Their noise is the one of amcl's corrected models."""

_NO_SKIPPING = (
    "beams that few particles explain are not skipped: people and moved objects are weighed down by their model"
)
_MAP_OF_FILE = "the map is that of the robot file"
_STORED_POSE = "the cloud stores the last pose of a robot by itself"

_SHARED: ParameterRules = {
    **same(
        _AMCL, "update_min_d", "update_min_a", "recovery_alpha_slow", "recovery_alpha_fast", "laser_min_range",
        "laser_max_range", "laser_likelihood_max_dist", "transform_tolerance", convert=number,
    ),
    **same(_AMCL, "min_particles", "max_particles", "resample_interval", convert=whole),
    **same(_AMCL, "odom_frame_id", "base_frame_id", "global_frame_id", convert=frame),
    **same(_AMCL, "tf_broadcast", convert=flag),
    **same(_AMCL, "laser_model_type", convert=one_of(LASER_MODELS)),
    **without_effect(
        _NO_SKIPPING, "do_beamskip", "beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"
    ),
    **without_effect(_STORED_POSE, "save_pose_rate"),
    **without_effect(_MAP_OF_FILE, "first_map_only"),
}  # fmt: skip

ROS1_RULES: ParameterRules = {
    **_SHARED,
    **same(
        _AMCL, "kld_err", "kld_z", "laser_z_hit", "laser_z_short", "laser_z_max", "laser_z_rand", "laser_sigma_hit",
        "laser_lambda_short", "odom_alpha1", "odom_alpha2", "odom_alpha3", "odom_alpha4", "odom_alpha5",
        "initial_cov_xx", "initial_cov_yy", "initial_cov_aa", convert=number,
    ),
    **same(_AMCL, "laser_max_beams", convert=whole),
    **same(_AMCL, "odom_model_type", convert=one_of(ODOMETRY_MODELS)),
    **same(_AMCL, "tf_prefix"),
    **without_effect(_NO_SKIPPING, "beam_skip_error_threshold_"),
    **without_effect("particles are drawn again every resample_interval updates", "selective_resampling"),
    **without_effect("the particles are published with each update", "gui_publish_rate"),
    **without_effect(_MAP_OF_FILE, "use_map_topic"),
    **without_effect(
        "the diagnostics of the robot report a pose that is uncertain", "std_warn_level_x", "std_warn_level_y",
        "std_warn_level_yaw",
    ),
    **without_effect("bags are read by ppaas bench localize", "bag_scan_period"),
    **without_effect("it belongs to dynamic_reconfigure", "restore_defaults"),
}  # fmt: skip
"""Rules of amcl of ROS 1, for its private parameters, without the ones of the initial pose."""

ROS1_POSE = ("initial_pose_x", "initial_pose_y", "initial_pose_a")

NAV2_RULES: ParameterRules = {
    **_SHARED,
    **renamed(
        _AMCL, convert=number, alpha1="odom_alpha1", alpha2="odom_alpha2", alpha3="odom_alpha3", alpha4="odom_alpha4",
        alpha5="odom_alpha5", pf_err="kld_err", pf_z="kld_z", z_hit="laser_z_hit", z_short="laser_z_short",
        z_max="laser_z_max", z_rand="laser_z_rand", sigma_hit="laser_sigma_hit", lambda_short="laser_lambda_short",
    ),
    **renamed(_AMCL, convert=whole, max_beams="laser_max_beams"),
    **renamed(_AMCL, convert=one_of(MOTION_MODELS), robot_model_type="odom_model_type"),
    "random_seed": ParameterRule(_AMCL + "seed", "a negative one is 0 here", lambda value: max(0, whole(value))),
    **without_effect("a robot that is searched for is searched everywhere on the map", "freespace_downsampling"),
    **without_effect(_MAP_OF_FILE, "map_topic"),
    **without_effect("the bridge of the robot, or its client, sends its scans as 'scan'", "scan_topic"),
    **without_effect("a robot starts where it was last; 'initialpose' moves it", "always_reset_initial_pose"),
    **without_effect("robots drive on a floor", "initial_pose.z"),
    **without_effect(
        "the field initial_pose of the robot file is used if set_initial_pose is true", "set_initial_pose",
        "initial_pose.x", "initial_pose.y", "initial_pose.yaw",
    ),
}  # fmt: skip
"""Rules of amcl of Nav2. The initial pose is translated together."""
