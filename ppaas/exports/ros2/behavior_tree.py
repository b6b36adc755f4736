"""Behaviour tree of Nav2 that plans, drives and recovers in the order in which Move Base does."""

import math
from collections.abc import Callable, Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

from ppaas.exports.ros2.draft import SetupDraft, renamed, same, without_effect
from ppaas.imports.parameters.rules import ParameterRules
from ppaas.navigation.parameters import MoveBaseParameters, recovery_behaviors
from ppaas.parameters import read_parameters
from ppaas.recoveries.registry import RECOVERIES

BEHAVIORS = "behavior_server"

IN_TREE = "in the behaviour tree"

RULES: Mapping[str, ParameterRules] = {
    "rotate_recovery": renamed(
        BEHAVIORS, max_rotational_vel="max_rotational_vel", min_in_place_rotational_vel="min_rotational_vel",
        acc_lim_th="rotational_acc_lim",
    ),
    "back_up": same(BEHAVIORS, "simulate_ahead_time"),
    "wait": {},
    "clear_costmap_recovery": without_effect("Nav2 clears all layers with observed obstacles", "layer_names"),
}  # fmt: skip
"""What becomes of the parameters of recovery behaviours by their kind; those without a rule are in the tree."""

TREE = {
    "rotate_recovery": ("spin_dist", "rotation_patience"),
    "back_up": ("backup_dist", "backup_speed", "time_allowance"),
    "wait": ("wait_duration",),
    "clear_costmap_recovery": ("reset_distance", "affected_maps"),
}
"""Parameters that are attributes in the tree."""


def add_behaviors(draft: SetupDraft) -> None:
    """Add the behaviour server."""
    release = draft.release
    plugins = {"spin": "Spin", "backup": "BackUp", "wait": "Wait"}
    draft.put(f"{BEHAVIORS}.behavior_plugins", list(plugins))
    for name, plugin in plugins.items():
        draft.put(f"{BEHAVIORS}.{name}.plugin", release.plugin("nav2_behaviors", plugin))
    of_local = "" if release.is_humble else "local_"
    draft.put(f"{BEHAVIORS}.{of_local}costmap_topic", "local_costmap/costmap_raw")
    draft.put(f"{BEHAVIORS}.{of_local}footprint_topic", "local_costmap/published_footprint")
    draft.put(f"{BEHAVIORS}.{of_local or 'global_'}frame", "odom")
    draft.put(f"{BEHAVIORS}.robot_base_frame", "base_link")


def behavior_tree(draft: SetupDraft) -> str:
    """Return the tree as XML, and report the recovery behaviours."""
    move_base = read_parameters(MoveBaseParameters, "move_base", draft.robot.in_use["move_base"])
    recoveries: list[str] = []
    reported: set[str] = set()
    for each in recovery_behaviors(move_base):
        kind = RECOVERIES.own_name(each.type)
        values = draft.robot.in_use.get(each.name, {})
        if kind not in RULES:
            draft.report.refused(f"recovery_behaviors.{each.name}", f"Nav2 has no behaviour like {kind}: left out")
            continue
        if each.name not in reported:
            reported.add(each.name)
            _report(draft, each.name, kind, values)
        recoveries += _LINES[kind](values, draft.release.is_humble)
    frequency = move_base.planner_frequency
    return "\n".join((draft.release.tree, *_indented(_tree(frequency, recoveries, draft)), "</root>", ""))


def _report(draft: SetupDraft, name: str, kind: str, values: Mapping[str, Any]) -> None:
    in_tree = {key: value for key, value in values.items() if key in TREE[kind]}
    draft.section(name, RULES[kind], {key: value for key, value in values.items() if key not in in_tree})
    for key, value in in_tree.items():
        draft.report.translated(f"{name}.{key}", f"{value!r} {IN_TREE}")


def _tree(frequency: float, recoveries: list[str], draft: SetupDraft) -> list[str]:
    """Return the lines of the tree: planning again at a rate, or only when control fails if that is 0."""
    plan = '<ComputePathToPose goal="{goal}" path="{path}" planner_id="GridBased"/>'
    at_rate = [f'<RateController hz="{frequency:g}">', f"  {plan}", "</RateController>"]
    planning = at_rate if frequency > 0.0 else [plan]
    sequence = "PipelineSequence" if frequency > 0.0 else "Sequence"
    rate = f"{frequency:g} Hz" if frequency > 0.0 else "when control fails"
    draft.report.translated("move_base.planner_frequency", f"{rate} {IN_TREE}")
    drive = [
        f'<{sequence} name="NavigateWithReplanning">',
        *_indented([*planning, '<FollowPath path="{path}" controller_id="FollowPath"/>']),
        f"</{sequence}>",
    ]
    if recoveries:
        recover = [
            '<ReactiveFallback name="RecoveryFallback">',
            *_indented(
                ["<GoalUpdated/>", '<RoundRobin name="RecoveryActions">', *_indented(recoveries), "</RoundRobin>"]
            ),
            "</ReactiveFallback>",
        ]
        count = sum(not line.startswith((" ", "</")) for line in recoveries)
        drive = [
            f'<RecoveryNode number_of_retries="{count}" name="NavigateRecovery">',
            *_indented([*drive, *recover]),
            "</RecoveryNode>",
        ]
    return ['<BehaviorTree ID="NavigateToPose">', *_indented(drive), "</BehaviorTree>"]


def _indented(lines: list[str]) -> list[str]:
    return [f"  {line}" for line in lines]


# -- recovery behaviours -----------------------------------------------------------------------------------------------


def _spin(values: Mapping[str, Any], _humble: bool) -> list[str]:
    return [f'<Spin spin_dist="{values["spin_dist"]:.6g}" time_allowance="{values["rotation_patience"]:g}"/>']


def _back_up(values: Mapping[str, Any], _humble: bool) -> list[str]:
    distance, speed, allowed = (values[name] for name in TREE["back_up"])
    return [f'<BackUp backup_dist="{distance:g}" backup_speed="{speed:g}" time_allowance="{allowed:g}"/>']


def _wait(values: Mapping[str, Any], humble: bool) -> list[str]:
    seconds = values["wait_duration"]
    return [f'<Wait wait_duration="{math.ceil(seconds) if humble else seconds:g}"/>']


def _clear(values: Mapping[str, Any], _humble: bool) -> list[str]:
    """Return the node that clears one costmap, or a sequence of two: all of it, or what is farther than a distance."""
    distance, affected = values["reset_distance"], values["affected_maps"]
    costmaps = [name for name in ("local", "global") if affected in (name, "both")]
    lines = [_clear_one(name, distance) for name in costmaps]
    return lines if len(lines) == 1 else ['<Sequence name="ClearCostmaps">', *_indented(lines), "</Sequence>"]


def _clear_one(costmap: str, distance: float) -> str:
    if distance == 0.0:
        service = f"{costmap}_costmap/clear_entirely_{costmap}_costmap"
        return f"<ClearEntireCostmap service_name={quoteattr(service)}/>"
    service = f"{costmap}_costmap/clear_except_{costmap}_costmap"
    return f'<ClearCostmapExceptRegion service_name={quoteattr(service)} reset_distance="{distance:g}"/>'


_LINES: Mapping[str, Callable[[Mapping[str, Any], bool], list[str]]] = {
    "rotate_recovery": _spin, "back_up": _back_up, "wait": _wait, "clear_costmap_recovery": _clear,
}  # fmt: skip
