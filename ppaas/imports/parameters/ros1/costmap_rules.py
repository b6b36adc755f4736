"""Rules for the parameters of costmap_2d of ROS 1: common ones, and those of the two costmaps."""

from ppaas.clone.surroundings import MAX_PUBLISH_FREQUENCY
from ppaas.imports.parameters.outline_rules import OUTLINE_RULES
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules, same, without_effect
from ppaas.imports.parameters.values import at_most

GLOBAL, LOCAL = "parameters.global_costmap.", "parameters.local_costmap."

_FRAMES = "frames are named in amcl or grid_slam"
_LAYERS = "the layers are the map, the obstacles that scans show, people, zones, and the octomap of the map"
_SCANS = "obstacles are what the scans of the robot show, whatever the topic"
_PLANE = "scans are projected to the ground; heights are those of voxel_layer, for the octomap of a map"
_WINDOW = "the local costmap moves with the robot, and the global one is the map"
_UPDATES = "costmaps change with each scan"
_STALE = "scans and poses may be as old as move_base's transform_tolerance, which a cloud needs longer"
_SHOWN = f"at most {MAX_PUBLISH_FREQUENCY:g} Hz"

EITHER: ParameterRules = {
    **without_effect(_FRAMES, "global_frame", "robot_base_frame"),
    **without_effect(_UPDATES, "update_frequency", "subscribe_to_updates", "always_send_full_costmap"),
    **without_effect(
        _LAYERS, "plugins", "map_type", "layers", "name", "type", "enabled", "combination_method", "use_maximum",
        "inflate_unknown",
    ),
    **without_effect(
        _WINDOW, "static_map", "rolling_window", "first_map_only", "map_topic", "origin_x", "origin_y", "resolution",
        "trinary_costmap", "unknown_cost_value",
    ),
    **without_effect(
        _SCANS, "observation_sources", "sensor_frame", "data_type", "topic", "marking", "clearing",
        "observation_persistence", "expected_update_rate", "observation_topic", "inf_is_valid",
        "footprint_clearing_enabled",
    ),
    **without_effect(
        _PLANE, "max_obstacle_height", "min_obstacle_height", "origin_z", "z_resolution", "z_voxels",
        "unknown_threshold", "mark_threshold", "publish_voxel_map",
    ),
    **without_effect("both follow from the footprint", "inscribed_radius", "circumscribed_radius"),
    "transform_tolerance": ParameterRule(text=_STALE),
    "restore_defaults": ParameterRule(text="it belongs to dynamic_reconfigure"),
}  # fmt: skip
"""Rules without effect in either costmap, for their layers and sources, too."""

_OUTLINE: ParameterRules = {
    **OUTLINE_RULES,
    "footprint_padding": ParameterRule(LOCAL + "footprint_padding"),
}

GLOBAL_RULES: ParameterRules = {
    **EITHER,
    **_OUTLINE,
    "inflation_radius": ParameterRule(GLOBAL + "inflation_radius"),
    "cost_scaling_factor": ParameterRule(GLOBAL + "cost_scaling_factor"),
    "lethal_cost_threshold": ParameterRule(GLOBAL + "lethal_cost_threshold"),
    "track_unknown_space": ParameterRule("parameters.static_layer.track_unknown_space"),
    "publish_frequency": ParameterRule(text="the global costmap is published when it changes"),
    **without_effect(_WINDOW, "width", "height"),
    **without_effect(
        "obstacles are remembered beyond the local costmap as they are in it", "obstacle_range", "raytrace_range",
    ),
}  # fmt: skip
"""Rules of the global costmap."""

LOCAL_RULES: ParameterRules = {
    **EITHER,
    **_OUTLINE,
    **same(
        LOCAL, "width", "height", "inflation_radius", "cost_scaling_factor", "obstacle_range", "raytrace_range"
    ),
    "publish_frequency": ParameterRule(LOCAL + "publish_frequency", _SHOWN, at_most(MAX_PUBLISH_FREQUENCY)),
    **without_effect("the map of the robot file decides", "lethal_cost_threshold", "track_unknown_space"),
}  # fmt: skip
"""Rules of the local costmap."""

COMMON_RULES: ParameterRules = {
    **GLOBAL_RULES,
    **{name: rule for name, rule in LOCAL_RULES.items() if not GLOBAL_RULES[name].to},
}
"""Rules of parameters of both costmaps; `BOTH` have a place in each."""

BOTH = ("inflation_radius", "cost_scaling_factor")
"""Common parameters that each costmap has."""

RANGES = ("obstacle_range", "raytrace_range")
"""Parameters of a source of observations that count for a laser."""
