"""Parameters of Nav2's controller server, with its controller, and of its planner server."""

from collections.abc import Mapping
from typing import Any

from ppaas.exports.ros2.draft import ELSEWHERE, SetupDraft, renamed, same, without_effect
from ppaas.exports.ros2.releases import Release
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules

SERVER, CONTROLLER = "controller_server", "controller_server.FollowPath"
CHECKER, PROGRESS = f"{SERVER}.general_goal_checker", f"{SERVER}.progress_checker"

_OUTLINE, _UNKNOWN = map(ParameterRule, ELSEWHERE)

_COMMON: ParameterRules = {
    **same(CHECKER, "xy_goal_tolerance", "yaw_goal_tolerance"),
    **renamed(CHECKER, trans_stopped_vel="trans_stopped_velocity", rot_stopped_vel="rot_stopped_velocity"),
    "robot_radius": _OUTLINE,
    "footprint": _OUTLINE,
    "allow_unknown": _UNKNOWN,
    **without_effect("Nav2 has no angle above which a near goal is not approached any more", "rotate_threshold"),
}
"""What becomes of the parameters that all local planners have."""

DWB_RULES: ParameterRules = {
    **_COMMON,
    **same(
        CONTROLLER, "max_vel_x", "min_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "sim_time", "vx_samples"
    ),
    **renamed(
        CONTROLLER, min_vel_trans="min_speed_xy", min_vel_theta="min_speed_theta", vth_samples="vtheta_samples",
        sim_granularity="linear_granularity",
    ),
    "path_distance_bias": ParameterRule(f"{CONTROLLER}.PathDist.scale", "the critics of DWB weigh other distances"),
    "goal_distance_bias": ParameterRule(f"{CONTROLLER}.GoalDist.scale", "the critics of DWB weigh other distances"),
    "occdist_scale": ParameterRule(
        f"{CONTROLLER}.BaseObstacle.scale", "half, since two critics of DWB have each of the other weights",
        lambda scale: 0.5 * float(scale),
    ),
    "forward_point_distance": ParameterRule(f"{CONTROLLER}.PathAlign.forward_point_distance"),
    **without_effect("DWB does not slow down near obstacles", "cost_slowdown"),
}  # fmt: skip
"""What becomes of the parameters of ``dwa``."""

RPP_SAME = (
    "lookahead_dist", "use_velocity_scaled_lookahead_dist", "min_lookahead_dist", "max_lookahead_dist",
    "lookahead_time", "use_fixed_curvature_lookahead", "curvature_lookahead_dist", "use_rotate_to_heading",
    "rotate_to_heading_min_angle", "rotate_to_heading_angular_vel", "allow_reversing",
    "use_regulated_linear_velocity_scaling", "regulated_linear_scaling_min_radius",
    "regulated_linear_scaling_min_speed", "use_cost_regulated_linear_velocity_scaling", "cost_scaling_dist",
    "cost_scaling_gain", "inflation_cost_scaling_factor", "approach_velocity_scaling_dist",
    "min_approach_linear_velocity", "use_collision_detection", "max_allowed_time_to_collision_up_to_carrot",
)  # fmt: skip

_RPP_LIMITS = "the controller turns and accelerates as far as its own parameters say"

MPPI_TUNED = ("batch_size", "time_steps", "iteration_count", "gamma", "vx_std", "wz_std")
"""Parameters of ``mppi`` whose defaults are tuned for its own sampling."""

_MPPI_COSTS = "our costs are times of travel, those of Nav2's critics are not"

MPPI_RULES: ParameterRules = {
    **_COMMON,
    **renamed(
        CONTROLLER, max_vel_x="vx_max", min_vel_x="vx_min", max_vel_theta="wz_max", acc_lim_x="ax_max",
        acc_lim_theta="az_max",
    ),
    **same(CONTROLLER, "model_dt", *MPPI_TUNED),
    **without_effect("MPPI has no least speed", "min_vel_trans", "min_vel_theta"),
    **without_effect(
        _MPPI_COSTS, "temperature", "collision_cost", "collision_margin_distance", "critical_weight",
        "critical_distance", "repulsion_weight", "inflation_length", "prefer_forward_weight", "turn_weight",
    ),
    **without_effect("Nav2's MPPI does not predict moving obstacles", "moving_weight", "moving_distance"),
    **without_effect("Nav2's MPPI takes commands as obeyed at once", "command_delay", "motor_lag"),
    **without_effect("Nav2's MPPI draws other numbers", "seed"),
}  # fmt: skip
"""What becomes of the parameters of ``mppi``."""


def rpp_rules(release: Release) -> ParameterRules:
    """Return what becomes of the parameters of ``pure_pursuit``."""
    return {
        **_COMMON,
        **same(CONTROLLER, *RPP_SAME),
        **renamed(CONTROLLER, max_vel_x=release.full_speed, acc_lim_theta="max_angular_accel"),
        **without_effect(
            _RPP_LIMITS, "min_vel_x", "max_vel_theta", "acc_lim_x", "min_vel_trans", "min_vel_theta"
        ),
    }  # fmt: skip


def add_controller(draft: SetupDraft) -> None:
    """Add the controller server with the robot's local planner, or MPPI in place of one that Nav2 does not have."""
    name, release = draft.robot.controller, draft.release
    draft.put(f"{SERVER}.controller_plugins", ["FollowPath"])
    draft.put(f"{SERVER}.goal_checker_plugins", ["general_goal_checker"])
    draft.put(f"{CHECKER}.plugin", "nav2_controller::StoppedGoalChecker")
    draft.put(f"{CHECKER}.stateful", True)
    _add_progress_checker(draft)
    if name == "dwa":
        _add_dwb(draft)
    elif name == "pure_pursuit":
        draft.put(f"{CONTROLLER}.plugin", "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController")
        values = dict(draft.robot.in_use[name])
        if values["allow_reversing"] and values.pop("use_rotate_to_heading"):
            draft.put(f"{CONTROLLER}.use_rotate_to_heading", False)
            draft.report.translated(f"{name}.use_rotate_to_heading", "False: in Nav2, it excludes allow_reversing")
        draft.section(name, rpp_rules(release), values)
    elif name == "mppi":
        _add_mppi(draft)
        _tune_mppi(draft)
    else:
        _add_mppi(draft)
        draft.report.refused(f"base_local_planner.{name}", "Nav2 has no such controller: MPPI is in its place")
        limits = draft.robot.body.limits
        _put_all(draft, {"vx_max": limits.max_vel_x, "vx_min": limits.min_vel_x, "wz_max": limits.max_vel_theta})
        return
    draft.report.translated("base_local_planner", f"{name} is {draft.value(SERVER, 'FollowPath.plugin')}")


def _add_progress_checker(draft: SetupDraft) -> None:
    """Add the check whether the robot gets on, by the parameters of oscillation, or else of the patience."""
    move_base = draft.robot.in_use["move_base"]
    if draft.release.is_humble:
        draft.put(f"{SERVER}.progress_checker_plugin", "progress_checker")
    else:
        draft.put(f"{SERVER}.progress_checker_plugins", ["progress_checker"])
    draft.put(f"{PROGRESS}.plugin", "nav2_controller::SimpleProgressChecker")
    draft.put(f"{PROGRESS}.required_movement_radius", float(move_base["oscillation_distance"]))
    allowed = float(move_base["oscillation_timeout"] or move_base["controller_patience"] or 10.0)
    draft.put(f"{PROGRESS}.movement_time_allowance", allowed)
    why = "" if move_base["oscillation_timeout"] else ": Nav2 does not do without this check"
    draft.report.translated("move_base.oscillation_timeout", f"{PROGRESS}.movement_time_allowance = {allowed:g}{why}")


def _add_dwb(draft: SetupDraft) -> None:
    draft.put(f"{CONTROLLER}.plugin", "dwb_core::DWBLocalPlanner")
    draft.put(f"{CONTROLLER}.trajectory_generator_name", "dwb_plugins::LimitedAccelGenerator")
    draft.put(
        f"{CONTROLLER}.critics",
        ["RotateToGoal", "Oscillation", "BaseObstacle", "GoalAlign", "PathAlign", "PathDist", "GoalDist"],
    )
    draft.section("dwa", DWB_RULES)
    dwa = draft.robot.in_use["dwa"]
    also = {
        "max_speed_xy": dwa["max_vel_x"], "decel_lim_x": -dwa["acc_lim_x"], "decel_lim_theta": -dwa["acc_lim_theta"],
        "min_vel_y": 0.0, "max_vel_y": 0.0, "acc_lim_y": 0.0, "decel_lim_y": 0.0,
        "xy_goal_tolerance": dwa["xy_goal_tolerance"], "trans_stopped_velocity": dwa["trans_stopped_vel"],
        "PathAlign.scale": dwa["path_distance_bias"], "GoalAlign.scale": dwa["goal_distance_bias"],
        "GoalAlign.forward_point_distance": dwa["forward_point_distance"], "RotateToGoal.scale": 32.0,
    }  # fmt: skip
    _put_all(draft, also)


def _add_mppi(draft: SetupDraft) -> None:
    critics = [
        "ConstraintCritic", draft.release.obstacle_critic, "GoalCritic", "GoalAngleCritic", "PathAlignCritic",
        "PathFollowCritic", "PathAngleCritic", "PreferForwardCritic",
    ]  # fmt: skip
    draft.put(f"{CONTROLLER}.plugin", "nav2_mppi_controller::MPPIController")
    draft.put(f"{CONTROLLER}.critics", critics)


def _tune_mppi(draft: SetupDraft) -> None:
    """Add the parameters of ``mppi``."""
    mppi = dict(draft.robot.in_use["mppi"])
    draft.put(f"{CONTROLLER}.ax_min", -float(mppi["acc_lim_x"]))
    period = 1.0 / float(draft.robot.in_use["move_base"]["controller_frequency"])
    if mppi["model_dt"] < period:
        del mppi["model_dt"]
        draft.put(f"{CONTROLLER}.model_dt", period)
        draft.report.translated("mppi.model_dt", f"{period:g}: in Nav2, a step is at least a period of the controller")
    why = "tuned for our sampling: Nav2's MPPI has its own default"
    draft.section("mppi", MPPI_RULES, mppi, tuned=MPPI_TUNED, why=why)


def _put_all(draft: SetupDraft, values: Mapping[str, Any]) -> None:
    for name, value in values.items():
        draft.put(f"{CONTROLLER}.{name}", value)


# -- planner -----------------------------------------------------------------------------------------------------------

PLANNERS, PLANNER = "planner_server", "planner_server.GridBased"

_NAVFN = ("nav2_navfn_planner", "NavfnPlanner")

PLUGINS: Mapping[str, tuple[str, str]] = {
    "dijkstra": _NAVFN, "navfn": _NAVFN, "jps": _NAVFN, "dstar_lite": _NAVFN, "hub_labels": _NAVFN,
    "astar": ("nav2_smac_planner", "SmacPlanner2D"),
    "theta_star": ("nav2_theta_star_planner", "ThetaStarPlanner"),
    "lattice": ("nav2_smac_planner", "SmacPlannerHybrid"),
}  # fmt: skip
"""Planners of ours, and the plug-ins of Nav2 that find paths of the same kind."""

GRID_RULES: ParameterRules = {
    **same(PLANNER, "allow_unknown", "use_astar"),
    **without_effect("Nav2 smooths paths in its smoother server, which this set-up does not use", "smooth"),
}

LATTICE_RULES: ParameterRules = {
    **same(
        PLANNER, "allow_unknown", "tolerance", "max_iterations", "max_planning_time", "motion_model_for_search",
        "minimum_turning_radius", "angle_quantization_bins", "allow_primitive_interpolation",
        "analytic_expansion_ratio", "analytic_expansion_max_length", "reverse_penalty", "non_straight_penalty",
        "change_penalty", "cost_penalty", "retrospective_penalty", "smooth_path",
    ),
    "footprint": _OUTLINE,
}  # fmt: skip
"""What becomes of the parameters of ``lattice``."""


def add_planner(draft: SetupDraft) -> None:
    """Add the planner server with the robot's planner, or NavFn in place of one that Nav2 does not have."""
    name = draft.robot.planner
    package, plugin = PLUGINS.get(name, _NAVFN)
    draft.put(f"{PLANNERS}.planner_plugins", ["GridBased"])
    draft.put(f"{PLANNER}.plugin", draft.release.plugin(package, plugin))
    if name not in PLUGINS:
        draft.report.refused(f"base_global_planner.{name}", "Nav2 has no such planner: NavFn is in its place")
    else:
        draft.report.translated("base_global_planner", f"{name} is {package}'s {plugin}")
        draft.section(name, LATTICE_RULES if name == "lattice" else GRID_RULES)
    if (package, plugin) == _NAVFN and name in ("jps", "dstar_lite"):
        draft.put(f"{PLANNER}.use_astar", True)
    for other in PLUGINS:
        if other != name:
            draft.unused(other, "a planner that only requests over REST name")
    _limit_planning(draft, package, plugin)


def _limit_planning(draft: SetupDraft, package: str, plugin: str) -> None:
    """Add the tolerance [m] and the time limit [s] of Move Base to those planners of Nav2 that have them."""
    tolerance, timeout = (draft.robot.in_use["move_base"][key] for key in ("default_tolerance", "planner_timeout"))
    wanted: dict[str, tuple[str, float | None]] = {"default_tolerance": ("tolerance", None)}
    if plugin != "ThetaStarPlanner":
        own = draft.value(PLANNERS, "GridBased.tolerance")
        wanted["default_tolerance"] = "tolerance", max(float(tolerance), float(own or 0.0))
    wanted["planner_timeout"] = "max_planning_time", None
    if package == "nav2_smac_planner":
        own = draft.value(PLANNERS, "GridBased.max_planning_time")
        wanted["planner_timeout"] = "max_planning_time", float(timeout if own is None else min(own, timeout))
    for name, (there, value) in wanted.items():
        if value is None:
            draft.report.without_effect(f"move_base.{name}", f"Nav2's {plugin} has no {there}")
        else:
            draft.put(f"{PLANNER}.{there}", value)
            draft.report.translated(f"move_base.{name}", f"{PLANNER}.{there} = {value:g}")
