"""Parameters of ``amcl``."""

from ppaas.imports.parameters.nav2.tables import NodeTable, rules_of
from ppaas.imports.parameters.rules import Convert
from ppaas.imports.parameters.values import flag, frame, number, one_of, whole

MOTION_MODELS = {
    "nav2_amcl::DifferentialMotionModel": "diff-corrected",
    "nav2_amcl::OmniMotionModel": "omni-corrected",
    "differential": "diff-corrected",
    "omnidirectional": "omni-corrected",
}
"""Motion models by name; before Humble they had short names. Nav2's noise is the one of amcl's corrected models."""

LASER_MODELS = {name: name for name in ("likelihood_field", "likelihood_field_prob", "beam")}

_SAME = (
    "laser_likelihood_max_dist laser_max_range laser_min_range max_particles min_particles recovery_alpha_fast "
    "recovery_alpha_slow resample_interval tf_broadcast transform_tolerance update_min_a update_min_d "
    "base_frame_id global_frame_id odom_frame_id laser_model_type"
)

_WHOLE = ("max_particles", "min_particles", "resample_interval")
_FRAMES = ("base_frame_id", "global_frame_id", "odom_frame_id")
_CONVERT: dict[str, Convert] = {
    **dict.fromkeys(_SAME.split(), number),
    **dict.fromkeys(_WHOLE, whole),
    **dict.fromkeys(_FRAMES, frame),
    "tf_broadcast": flag,
    "laser_model_type": one_of(LASER_MODELS),
}

AMCL = NodeTable(
    "amcl",
    rules_of(
        "amcl",
        _SAME,
        {
            **{f"alpha{number_}": (f"odom_alpha{number_}", number) for number_ in range(1, 6)},
            "lambda_short": ("laser_lambda_short", number),
            "max_beams": ("laser_max_beams", whole),
            "pf_err": ("kld_err", number),
            "pf_z": ("kld_z", number),
            "robot_model_type": ("odom_model_type", one_of(MOTION_MODELS)),
            "sigma_hit": ("laser_sigma_hit", number),
            "z_hit": ("laser_z_hit", number),
            "z_max": ("laser_z_max", number),
            "z_rand": ("laser_z_rand", number),
            "z_short": ("laser_z_short", number),
        },
        {
            "no beams are skipped": (
                "do_beamskip beam_skip_distance beam_skip_error_threshold beam_skip_threshold"
            ),
            "the cloud keeps the pose of the robot in checkpoints": "save_pose_rate always_reset_initial_pose",
            "the clone has the map and the scans of its robot": "map_topic scan_topic first_map_only",
            "all free cells of the map are used": "freespace_downsampling",
            "the height of the start is 0": "initial_pose.z",
            "the field initial_pose of the robot file is used if set_initial_pose is true": (
                "set_initial_pose initial_pose.x initial_pose.y initial_pose.yaw"
            ),
            "the random numbers have the seed 0": "random_seed",
        },
        _CONVERT,
    ),
)  # fmt: skip
