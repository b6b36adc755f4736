"""Rules for the parameters of move_base of ROS 1, and of its global planners and recovery behaviours."""

from typing import Any

from ppaas.errors import InvalidParameter
from ppaas.imports.nearest_name import nearest_name
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, same, without_effect
from ppaas.planners.registry import PLANNERS
from ppaas.recoveries.registry import RECOVERIES

_MOVE_BASE = "parameters.move_base."

_OTHER_PLANNERS = {"sbpl_lattice_planner/SBPLLatticePlanner": "lattice", "carrot_planner/CarrotPlanner": "theta_star"}
"""Global planners of ROS 1 that no plug-in has as an alias, and the plug-ins most like them."""


def global_planner(value: object) -> str:
    """Return the plug-in of a global planner by its name in ROS.

    Raises
    ------
    InvalidParameter
        No plug-in is like it.
    """
    name = str(value)
    if name in _OTHER_PLANNERS:
        return _OTHER_PLANNERS[name]
    if name in PLANNERS:
        return PLANNERS.own_name(name)
    near = nearest_name(name, (*PLANNERS.names(), *_OTHER_PLANNERS, "global_planner/GlobalPlanner", "navfn/NavfnROS"))
    hint = f"did you mean {near!r}?" if near else "dijkstra plans, unless another is named"
    raise InvalidParameter(f"there is no planner {name!r}; {hint}")


def recovery_behaviors(value: object) -> list[dict[str, str]]:
    """Return a list of recovery behaviours with our names of their types.

    Raises
    ------
    InvalidParameter
        It is no list of behaviours, or there is no behaviour of a type.
    """
    if not isinstance(value, list) or not all(
        isinstance(each, dict) and {"name", "type"} <= each.keys() for each in value
    ):
        raise InvalidParameter("it must be a list of {name: …, type: …}")
    return [{"name": str(each["name"]), "type": _recovery(str(each["type"]))} for each in value]


def _recovery(kind: str) -> str:
    if kind not in RECOVERIES:
        raise InvalidParameter(f"there is no recovery behaviour {kind!r}; known: {', '.join(RECOVERIES.names())}")
    return RECOVERIES.own_name(kind)


MOVE_BASE: ParameterRules = {
    **same(
        _MOVE_BASE, "planner_frequency", "controller_frequency", "planner_patience", "controller_patience",
        "max_planning_retries", "oscillation_timeout", "oscillation_distance", "recovery_behavior_enabled",
        "clearing_rotation_allowed", "conservative_reset_dist",
    ),
    "base_global_planner": ParameterRule("base_global_planner", convert=global_planner),
    "recovery_behaviors": ParameterRule(_MOVE_BASE + "recovery_behaviors", convert=recovery_behaviors),
    **without_effect("costmaps of a clone are always there", "shutdown_costmaps", "global_costmap", "local_costmap"),
    **without_effect(
        "plans of services are made on the costmap as it is", "make_plan_clear_costmap",
        "make_plan_add_unreachable_goal",
    ),
    "planner_retry_frequency": ParameterRule(text="planning is tried again at planner_frequency"),
    "clearing_radius": ParameterRule(text="obstacles are cleared by the recovery behaviours"),
    "restore_defaults": ParameterRule(text="it belongs to dynamic_reconfigure"),
    "planner_max_retries": ParameterRule(_MOVE_BASE + "max_planning_retries"),
    "recovery_enabled": ParameterRule(_MOVE_BASE + "recovery_behavior_enabled"),
    "controller_max_retries": ParameterRule(text="the local planner is tried again until controller_patience"),
    "recovery_patience": ParameterRule(text="recovery behaviours end by themselves"),
    **without_effect("robots stop at their goals, and when these are cancelled", "force_stop_at_goal",
                     "force_stop_on_cancel"),
    **without_effect("the tolerances of the local planner hold", "mbf_tolerance_check", "dist_tolerance",
                     "angle_tolerance"),
    "oscillation_angle": ParameterRule(text="oscillation_distance alone says whether a robot gets on"),
    "tf_timeout": ParameterRule(text="transform_tolerance holds for all transforms"),
    "robot_frame": ParameterRule(text="frames are named in amcl or grid_slam"),
    "path_distance_bias": ParameterRule(text="it belongs to a local planner: write it below the planner's name"),
    "goal_distance_bias": ParameterRule(text="it belongs to a local planner: write it below the planner's name"),
}  # fmt: skip
"""Rules of move_base and move_base_flex. The local planner is translated with its parameters."""

PLUGIN_LISTS = {"planners": "base_global_planner", "controllers": "base_local_planner"}
"""Lists of plug-ins of move_base_flex, of which the first is the one that move_base names."""

VELOCITY_SMOOTHER: ParameterRules = without_effect(
    "commands change within the limits of speed and acceleration of the local planner",
    "speed_lim_v", "speed_lim_w", "accel_lim_v", "accel_lim_w", "decel_factor", "frequency", "robot_feedback",
)  # fmt: skip
"""Rules of yocs_velocity_smoother, which smooths the commands of move_base."""

_SAME_COSTS = "costs are weighed as by the costmap"
_NO_WINDOW = "the whole map is planned on"
_SHOWN = "potentials are not published"

NAVFN: ParameterRules = {
    "allow_unknown": ParameterRule("parameters.navfn.allow_unknown"),
    "default_tolerance": ParameterRule(_MOVE_BASE + "default_tolerance"),
    **without_effect(_NO_WINDOW, "planner_window_x", "planner_window_y"),
    **without_effect(_SHOWN, "visualize_potential"),
    "planner_costmap_publish_frequency": ParameterRule(text=_SHOWN),
}
"""Rules of navfn/NavfnROS."""

GLOBAL_PLANNER: ParameterRules = {
    "allow_unknown": ParameterRule("parameters.dijkstra.allow_unknown"),
    "default_tolerance": ParameterRule(_MOVE_BASE + "default_tolerance"),
    "clear_goal_tolerance": ParameterRule(text="a goal that is free stays where it is"),
    **without_effect(_NO_WINDOW, "planner_window_x", "planner_window_y"),
    **without_effect(
        _SHOWN, "visualize_potential", "publish_potential", "publish_scale", "planner_costmap_publish_frequency"
    ),
    **without_effect(_SAME_COSTS, "lethal_cost", "neutral_cost", "cost_factor"),
    "use_quadratic": ParameterRule(text="paths are exact on the grid"),
    "use_grid_path": ParameterRule(text="paths follow the cells; the planner's parameter 'smooth' shortens them"),
    "old_navfn_behavior": ParameterRule(text="base_global_planner navfn plans as navfn does"),
    "outline_map": ParameterRule(text="a map ends where it ends"),
    "orientation_mode": ParameterRule(text="poses of a path look along it, and the last one as the goal"),
    "orientation_window_size": ParameterRule(text="poses of a path look along it, and the last one as the goal"),
}
"""Rules of global_planner/GlobalPlanner. ``use_dijkstra`` is translated apart."""

CLEARING: ParameterRules = {
    "reset_distance": ParameterRule("reset_distance"),
    "layer_names": ParameterRule(
        "layer_names", "obstacles are the only layer that is cleared", lambda _: ["obstacles"]
    ),
    "affected_maps": ParameterRule("affected_maps"),
    "force_updating": ParameterRule(text="costmaps are updated with each scan"),
    "invert_area_to_clear": ParameterRule(text="obstacles beyond the distance are cleared"),
}
"""Rules of clear_costmap_recovery, whose places are below the name of the behaviour."""

ROTATING: ParameterRules = {
    "max_rotational_vel": ParameterRule("max_rotational_vel"),
    "min_in_place_rotational_vel": ParameterRule("min_in_place_rotational_vel"),
    "acc_lim_th": ParameterRule("acc_lim_th"),
    "sim_granularity": ParameterRule(text="the outline is checked every 0.1 rad"),
    "frequency": ParameterRule(text="it runs at controller_frequency"),
    "yaw_goal_tolerance": ParameterRule(text="it turns by the whole angle"),
}
"""Rules of rotate_recovery, whose places are below the name of the behaviour."""


def rules_of_recovery(kind: str) -> ParameterRules | None:
    """Return the rules of a recovery behaviour by its type; None if it has no parameters."""
    rules: dict[str, Any] = {"clear_costmap_recovery": CLEARING, "rotate_recovery": ROTATING}
    return rules.get(kind)
