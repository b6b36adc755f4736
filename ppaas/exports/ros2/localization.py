"""Parameters of Nav2's ``amcl`` and of slam_toolbox."""

from typing import Any

import msgspec

from ppaas.exports.ros2.draft import SetupDraft, renamed, same, without_effect
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules
from ppaas.localization.parameters import AmclParameters
from ppaas.nodes.grid_slam.parameters import GMAPPING, WITHOUT_EFFECT, GridSlamParameters
from ppaas.parameters import read_parameters

AMCL, SLAM, GRID_SLAM = "amcl", "slam_toolbox", "grid_slam"

FRAMES = {"odom_frame_id": "odom", "base_frame_id": "base_link", "global_frame_id": "map"}
"""Parameters that name frames, and their usual names, which stand for what the clone finds out by itself."""


def _motion(model: Any) -> str:
    kind = "Omni" if str(model).startswith("omni") else "Differential"
    return f"nav2_amcl::{kind}MotionModel"


def _frame(usual: str) -> Any:
    return lambda name: str(name) or usual


AMCL_RULES: ParameterRules = {
    **same(
        AMCL, "min_particles", "max_particles", "update_min_d", "update_min_a", "resample_interval",
        "recovery_alpha_slow", "recovery_alpha_fast", "laser_model_type", "laser_min_range", "laser_max_range",
        "laser_likelihood_max_dist", "transform_tolerance", "tf_broadcast",
    ),
    **renamed(
        AMCL, kld_err="pf_err", kld_z="pf_z", laser_max_beams="max_beams", laser_z_hit="z_hit", laser_z_short="z_short",
        laser_z_max="z_max", laser_z_rand="z_rand", laser_sigma_hit="sigma_hit", laser_lambda_short="lambda_short",
        odom_alpha1="alpha1", odom_alpha2="alpha2", odom_alpha3="alpha3", odom_alpha4="alpha4", odom_alpha5="alpha5",
    ),
    "odom_model_type": ParameterRule(
        f"{AMCL}.robot_model_type", "Nav2 has the corrected odometry model alone", _motion
    ),
    **{
        name: ParameterRule(f"{AMCL}.{name}", "", _frame(usual)) for name, usual in FRAMES.items()
    },
    **without_effect("Nav2's amcl has no noise of standing odometry", "odom_drift"),
    **without_effect(
        "Nav2's amcl starts with a spread that cannot be set", "initial_cov_xx", "initial_cov_yy", "initial_cov_aa"
    ),
    **without_effect("frames are named in full in ROS 2", "tf_prefix"),
    **without_effect("Nav2's amcl draws other numbers", "seed"),
}  # fmt: skip
"""What becomes of the parameters of ``amcl``."""


def add_amcl(draft: SetupDraft) -> None:
    """Add the parameters of ``amcl`` with the start pose of the robot, also of one that makes its map.

    A robot that localizes itself has no ``amcl``.
    """
    values = msgspec.structs.asdict(read_parameters(AmclParameters, AMCL, draft.robot.given.get(AMCL, {})))
    if not values.pop("localize"):
        draft.report.translated(f"{AMCL}.localize", "False: the launch file starts no amcl")
        for name in ("initial_pose", *(f"{AMCL}.{name}" for name in values if draft.robot.is_given(AMCL, name))):
            draft.report.without_effect(name, "the robot localizes itself")
        return
    draft.report.translated(f"{AMCL}.localize", "True: the launch file starts amcl")
    draft.section(AMCL, AMCL_RULES, values)
    x, y, yaw = draft.robot.file.get("initial_pose", (0.0, 0.0, 0.0))
    draft.put(f"{AMCL}.set_initial_pose", True)
    for name, value in {"x": x, "y": y, "z": 0.0, "yaw": yaw}.items():
        draft.put(f"{AMCL}.initial_pose.{name}", float(value))
    draft.report.translated("initial_pose", f"{AMCL}.initial_pose = {x:g}, {y:g}, {yaw:g}")


# -- slam_toolbox ------------------------------------------------------------------------------------------------------

OF_THE_MATCHER = (
    "scan_buffer_size", "correlation_search_space_dimension", "correlation_search_space_resolution",
    "correlation_search_space_smear_deviation", "coarse_angle_resolution", "loop_search_maximum_distance",
    "loop_search_space_resolution", "loop_search_space_smear_deviation", "loop_match_minimum_response_coarse",
    "loop_match_minimum_chain_size",
)  # fmt: skip
"""Parameters whose defaults are tuned for the matcher of ``grid_slam``."""

NOT_IN_SLAM_TOOLBOX = (
    "correlation_scans", "normal_angle", "normal_thickness", "odometry_deviation", "odometry_heading_deviation",
    "max_key_frames", "srr", "srt", "str", "stt", "inf_is_valid",
)  # fmt: skip

SLAM_RULES: ParameterRules = {
    **same(
        SLAM, "minimum_travel_distance", "minimum_travel_heading", "max_laser_range",
        "resolution", "throttle_scans", "minimum_time_interval", "map_update_interval", "transform_publish_period",
        "transform_timeout", "min_pass_through", "occupancy_threshold", "do_loop_closing", "paused_new_measurements",
        "map_frame", *OF_THE_MATCHER,
    ),
    **renamed(SLAM, minimum_laser_range="min_laser_range"),
    "odom_frame": ParameterRule(f"{SLAM}.odom_frame", "", _frame("odom")),
    "base_frame": ParameterRule(f"{SLAM}.base_frame", "", _frame("base_link")),
    "mode": ParameterRule(
        f"{SLAM}.mode", "lifelong mapping is another program of slam_toolbox: lifelong_slam_toolbox_node",
        lambda mode: "mapping" if mode == "lifelong" else str(mode),
    ),
    **without_effect("slam_toolbox has no such parameter", *NOT_IN_SLAM_TOOLBOX),
    **without_effect("frames are named in full in ROS 2", "tf_prefix"),
    **without_effect(
        "slam_toolbox continues its own files (`serialize_map`), and no pose graph of ours", "map_file_name",
        "map_start_pose",
    ),
    **same(SLAM, "lifelong_iou_match", *WITHOUT_EFFECT),
}  # fmt: skip
"""What becomes of the parameters of ``grid_slam``."""


def add_slam(draft: SetupDraft) -> None:
    """Add the parameters of slam_toolbox, also of a robot on a published map: it makes the next one by them."""
    given = draft.robot.given.get(GRID_SLAM, {})
    values = msgspec.structs.asdict(read_parameters(GridSlamParameters, GRID_SLAM, given))
    for alias, name in GMAPPING.items():
        value = values.pop(alias)
        if value is not None:
            values[name] = max(0.0, value)
            draft.report.translated(f"{GRID_SLAM}.{alias}", f"{GRID_SLAM}.{name} = {values[name]!r}")
    why = "its default is tuned for our matcher: slam_toolbox has its own"
    draft.section(GRID_SLAM, SLAM_RULES, values, tuned=OF_THE_MATCHER, why=why)
    draft.put(f"{SLAM}.scan_topic", "scan")
    draft.put(f"{SLAM}.use_scan_matching", True)
