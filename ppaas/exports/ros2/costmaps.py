"""Parameters of Nav2's costmaps: layers, outline of the robot, and filters by masks."""

import math
from typing import Any

from ppaas.exports.ros2.draft import COSTMAPS, SetupDraft, renamed, same
from ppaas.exports.ros2.masks import Masks
from ppaas.footprints import goes_around
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules

LOCAL, GLOBAL = COSTMAPS

SCAN = "obstacle_layer.scan"
"""Place of the observation source in both costmaps."""

SPEED_TOPIC = "speed_limit"
"""Topic of speed limits, Nav2's default."""


def _whole(metres: Any) -> int:
    """Return the edge of a window that Nav2 takes in whole metres."""
    return math.ceil(float(metres))


GLOBAL_RULES: ParameterRules = {
    **same(f"{GLOBAL}.inflation_layer", "inflation_radius", "cost_scaling_factor"),
    **same(GLOBAL, "lethal_cost_threshold"),
}
"""What becomes of the parameters of ``global_costmap``, beside the outline."""

LOCAL_RULES: ParameterRules = {
    **same(f"{LOCAL}.inflation_layer", "inflation_radius", "cost_scaling_factor"),
    **same(LOCAL, "footprint_padding", "publish_frequency"),
    **renamed(f"{LOCAL}.{SCAN}", obstacle_range="obstacle_max_range", raytrace_range="raytrace_max_range"),
    **{name: ParameterRule(f"{LOCAL}.{name}", "in whole metres", _whole) for name in ("width", "height")},
}
"""What becomes of the parameters of ``local_costmap``."""

_OCTOMAPS = "Nav2 reads no octomap: obstacles above or below the laser are in no costmap"

UNUSED_LAYERS = {
    "social_layer": "Nav2 has no layer of people",
    "voxel_layer": _OCTOMAPS,
}
"""Layers of the clone that Nav2 does not have."""


def add_costmaps(draft: SetupDraft, masks: Masks) -> None:
    """Add both costmaps with their layers and filters."""
    robot, tolerance = draft.robot, float(draft.robot.in_use["move_base"]["transform_tolerance"])
    for costmap in COSTMAPS:
        is_global = costmap == GLOBAL
        layers = [*(["static_layer"] if is_global else []), "obstacle_layer", "inflation_layer"]
        draft.put(f"{costmap}.global_frame", "map" if is_global else "odom")
        draft.put(f"{costmap}.robot_base_frame", "base_link")
        draft.put(f"{costmap}.rolling_window", not is_global)
        draft.put(f"{costmap}.transform_tolerance", tolerance)
        if robot.map is not None:
            draft.put(f"{costmap}.resolution", float(robot.map.grid.info.resolution))
        draft.put(f"{costmap}.track_unknown_space", bool(robot.in_use["static_layer"]["track_unknown_space"]))
        draft.put(f"{costmap}.plugins", layers)
        _put_layers(draft, costmap, layers)
        _put_filters(draft, costmap, masks)
        _put_outline(draft, costmap)
    draft.section(GLOBAL, GLOBAL_RULES, _without(robot.in_use[GLOBAL], "robot_radius", "footprint"))
    draft.section(LOCAL, LOCAL_RULES)
    for name in ("obstacle_max_range", "raytrace_max_range"):
        draft.put(f"{GLOBAL}.{SCAN}.{name}", draft.value(LOCAL, f"{SCAN}.{name}"))
    draft.report.taken("static_layer.track_unknown_space", f"{LOCAL} and {GLOBAL}")
    for layer, why in UNUSED_LAYERS.items():
        draft.unused(layer, why)
    if robot.map is not None and robot.map.has_octomap:
        draft.report.without_effect(f"map {robot.map.id}: octomap", _OCTOMAPS)


def _put_layers(draft: SetupDraft, costmap: str, layers: list[str]) -> None:
    types = {"static_layer": "StaticLayer", "obstacle_layer": "ObstacleLayer", "inflation_layer": "InflationLayer"}
    for layer in layers:
        draft.put(f"{costmap}.{layer}.plugin", f"nav2_costmap_2d::{types[layer]}")
    if "static_layer" in layers:
        draft.put(f"{costmap}.static_layer.map_subscribe_transient_local", True)
    source = {"topic": "/scan", "data_type": "LaserScan", "marking": True, "clearing": True, "max_obstacle_height": 2.0}
    draft.put(f"{costmap}.obstacle_layer.observation_sources", "scan")
    for name, value in source.items():
        draft.put(f"{costmap}.{SCAN}.{name}", value)


def _put_filters(draft: SetupDraft, costmap: str, masks: Masks) -> None:
    """Add the filters: both costmaps keep out, and one is enough for the speed."""
    wanted = [
        *(["keepout_filter"] if masks.keepout is not None else []),
        *(["speed_filter"] if masks.speed is not None and costmap == GLOBAL else []),
    ]
    if not wanted:
        return
    draft.put(f"{costmap}.filters", wanted)
    for name in wanted:
        kind = "KeepoutFilter" if name == "keepout_filter" else "SpeedFilter"
        draft.put(f"{costmap}.{name}.plugin", f"nav2_costmap_2d::{kind}")
        draft.put(f"{costmap}.{name}.enabled", True)
        draft.put(f"{costmap}.{name}.filter_info_topic", f"/{name}_info")
        if name == "speed_filter":
            draft.put(f"{costmap}.{name}.speed_limit_topic", SPEED_TOPIC)


def _put_outline(draft: SetupDraft, costmap: str) -> None:
    """Add the outline of the robot: its footprint if it goes around the origin, and else its radius."""
    body = draft.robot.body
    if goes_around(body.footprint):
        draft.put(f"{costmap}.footprint", str([[float(x), float(y)] for x, y in body.footprint]))
        if costmap == GLOBAL:
            draft.report.translated("global_costmap.footprint", f"{len(body.footprint)} corners, as text")
        return
    draft.put(f"{costmap}.robot_radius", float(body.robot_radius))
    if costmap == GLOBAL:
        draft.report.taken("global_costmap.robot_radius", f"{body.robot_radius:g} m, in both costmaps")


def _without(table: Any, *names: str) -> dict[str, Any]:
    return {name: value for name, value in table.items() if name not in names}


# -- servers of masks --------------------------------------------------------------------------------------------------


def add_mask_servers(draft: SetupDraft, masks: Masks) -> None:
    """Add the nodes that serve the masks, and those that say what their values mean."""
    for name, mask, kind in (("keepout", masks.keepout, 0), ("speed", masks.speed, 1)):
        if mask is None:
            continue
        server, info = f"{name}_filter_mask_server", f"{name}_costmap_filter_info_server"
        draft.put(f"{server}.topic_name", f"{name}_filter_mask")
        draft.put(f"{info}.type", kind)
        draft.put(f"{info}.filter_info_topic", f"/{name}_filter_info")
        draft.put(f"{info}.mask_topic", f"/{name}_filter_mask")
        draft.put(f"{info}.base", 0.0)
        draft.put(f"{info}.multiplier", 1.0)
