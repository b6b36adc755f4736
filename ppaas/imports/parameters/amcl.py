"""Parameters of amcl, in ROS 1 and in Nav2, as those of our node of that name."""

from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.known_names import apply_known, report_repeated, values_of_node
from ppaas.imports.parameters.launch_files import read_parameters
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, apply_rule, put
from ppaas.imports.report import ImportReport

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation

_AMCL = "parameters.amcl."
_LASER_MODELS = ("likelihood_field", "likelihood_field_prob", "beam")
_ODOMETRY_MODELS = ("diff", "omni", "diff-corrected", "omni-corrected")

_NO_SKIPPING = (
    "beams that few particles explain are not skipped: people and moved objects are weighed down by their model"
)
_MAP_OF_FILE = "the map is that of the robot file"
_STORED_POSE = "the cloud stores the last pose of a robot by itself"
_WARNING = "the diagnostics of the robot report a pose that is uncertain"


def motion_model(value: object) -> str:
    """Return the model of the odometry by the plug-in of Nav2, which has amcl's corrected models."""
    name = str(value).rpartition("::")[2].lower()
    models = {
        "differentialmotionmodel": "diff-corrected", "differential": "diff-corrected",
        "omnimotionmodel": "omni-corrected", "omnidirectional": "omni-corrected",
    }  # fmt: skip
    if name not in models:
        raise InvalidParameter(
            f"unknown motion model {value!r}; known: nav2_amcl::DifferentialMotionModel, OmniMotionModel"
        )
    return models[name]


def _one_of(known: tuple[str, ...]) -> Any:
    def check(value: object) -> object:
        if value not in known:
            raise InvalidParameter(f"{value!r} is none of {', '.join(known)}")
        return value

    return check


def _taken(*names: str) -> dict[str, ParameterRule]:
    return {name: ParameterRule(_AMCL + name) for name in names}


def _renamed(**names: str) -> dict[str, ParameterRule]:
    return {name: ParameterRule(_AMCL + own) for name, own in names.items()}


def frame(value: object) -> str:
    """Return the name of a frame without the slash at its begin, which tf has dropped.

    Raises
    ------
    InvalidParameter
        The value is no text.
    """
    if not isinstance(value, str):
        raise InvalidParameter(f"a frame must be text, not {value!r}")
    return value.lstrip("/")


_FRAMES = ("odom_frame_id", "base_frame_id", "global_frame_id")

_SHARED: ParameterRules = {
    **_taken(
        "min_particles", "max_particles", "update_min_d", "update_min_a", "resample_interval", "recovery_alpha_slow",
        "recovery_alpha_fast", "laser_min_range", "laser_max_range", "laser_likelihood_max_dist", "transform_tolerance",
        "tf_broadcast",
    ),
    "laser_model_type": ParameterRule(_AMCL + "laser_model_type", convert=_one_of(_LASER_MODELS)),
    **{name: ParameterRule(_AMCL + name, convert=frame) for name in _FRAMES},
    "do_beamskip": ParameterRule(text=_NO_SKIPPING),
    "beam_skip_distance": ParameterRule(text=_NO_SKIPPING),
    "beam_skip_threshold": ParameterRule(text=_NO_SKIPPING),
    "beam_skip_error_threshold": ParameterRule(text=_NO_SKIPPING),
    "save_pose_rate": ParameterRule(text=_STORED_POSE),
    "first_map_only": ParameterRule(text=_MAP_OF_FILE),
}  # fmt: skip

ROS1_RULES: ParameterRules = {
    **_SHARED,
    **_taken(
        "kld_err", "kld_z", "laser_max_beams", "laser_z_hit", "laser_z_short", "laser_z_max", "laser_z_rand",
        "laser_sigma_hit", "laser_lambda_short", "odom_alpha1", "odom_alpha2", "odom_alpha3", "odom_alpha4",
        "odom_alpha5", "initial_cov_xx", "initial_cov_yy", "initial_cov_aa",
    ),
    "odom_model_type": ParameterRule(_AMCL + "odom_model_type", convert=_one_of(_ODOMETRY_MODELS)),
    "tf_prefix": ParameterRule(_AMCL + "tf_prefix"),
    "beam_skip_error_threshold_": ParameterRule(text=_NO_SKIPPING),
    "selective_resampling": ParameterRule(text="particles are drawn again every resample_interval updates"),
    "gui_publish_rate": ParameterRule(text="the particles are published with each update"),
    "use_map_topic": ParameterRule(text=_MAP_OF_FILE),
    "std_warn_level_x": ParameterRule(text=_WARNING),
    "std_warn_level_y": ParameterRule(text=_WARNING),
    "std_warn_level_yaw": ParameterRule(text=_WARNING),
    "bag_scan_period": ParameterRule(text="bags are read by ppaas bench localize"),
    "restore_defaults": ParameterRule(text="it belongs to dynamic_reconfigure"),
}  # fmt: skip
"""Rules of amcl of ROS 1, for its private parameters, without those of the initial pose."""

ROS2_RULES: ParameterRules = {
    **_SHARED,
    **_renamed(
        alpha1="odom_alpha1", alpha2="odom_alpha2", alpha3="odom_alpha3", alpha4="odom_alpha4", alpha5="odom_alpha5",
        max_beams="laser_max_beams", pf_err="kld_err", pf_z="kld_z", z_hit="laser_z_hit", z_short="laser_z_short",
        z_max="laser_z_max", z_rand="laser_z_rand", sigma_hit="laser_sigma_hit", lambda_short="laser_lambda_short",
    ),
    "robot_model_type": ParameterRule(_AMCL + "odom_model_type", convert=motion_model),
    "random_seed": ParameterRule(_AMCL + "seed", "a negative one is 0 here", lambda value: max(0, int(value))),
    "freespace_downsampling": ParameterRule(text="a robot that is searched for is searched everywhere on the map"),
    "map_topic": ParameterRule(text=_MAP_OF_FILE),
    "scan_topic": ParameterRule(text="the bridge of the robot, or its client, sends its scans as 'scan'"),
    "set_initial_pose": ParameterRule(text="a robot starts at its initial pose, or where it was last"),
    "always_reset_initial_pose": ParameterRule(text="a robot starts where it was last; 'initialpose' moves it"),
    "initial_pose.z": ParameterRule(text="robots drive on a floor"),
}  # fmt: skip
"""Rules of amcl of Nav2, without those of the initial pose."""

ROS1_POSE = ("initial_pose_x", "initial_pose_y", "initial_pose_a")
ROS2_POSE = ("initial_pose.x", "initial_pose.y", "initial_pose.yaw")


def import_amcl(content: bytes, name: str) -> tuple[dict[str, Any], ImportReport]:
    """Translate a parameter file of amcl, of ROS 1 or of Nav2, or a launch file, into a part of a robot file.

    Raises
    ------
    InvalidParameter
        The file cannot be read as parameters.
    """
    report, draft = ImportReport(name), dict[str, Any]()
    file = read_parameters(content, report)
    report_repeated(file, report)
    node, given = values_of_node(file, lambda each: "amcl" in each, report)
    apply_amcl(given, node, (draft, report), is_ros2=file.is_ros2)
    return draft, report


def apply_amcl(given: dict[str, GivenValue], node: str, into: "Translation", *, is_ros2: bool) -> None:
    """Apply the rules of amcl to the parameters of its node; coordinates of its start that are not given are 0."""
    pose = ROS2_POSE if is_ros2 else ROS1_POSE
    rest = {name: value for name, value in given.items() if name not in pose}
    apply_known(ROS2_RULES if is_ros2 else ROS1_RULES, rest, node, into)
    draft, report = into
    for index, name in enumerate(pose):
        if name in given:
            rule = ParameterRule("initial_pose", "x, y [m] and yaw [rad]", _coordinate(draft, index))
            apply_rule(rule, f"{node}.{name}" if node else name, given[name], draft, report)


def _coordinate(draft: dict[str, Any], index: int) -> Any:
    """Return a function that returns the pose with this coordinate changed."""

    def changed(value: object) -> list[float]:
        pose = list(draft.get("initial_pose", (0.0, 0.0, 0.0)))
        pose[index] = float(value)  # type: ignore[arg-type]
        put(draft, "initial_pose", pose)
        return pose

    return changed
