"""Rules for the parameters of costmap_2d of ROS 1: common ones, and those of the two costmaps."""

from typing import Any

from ppaas.clone.surroundings import MAX_PUBLISH_FREQUENCY
from ppaas.errors import InvalidParameter
from ppaas.footprints import check_corners, read_footprint
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules

GLOBAL, LOCAL = "parameters.global_costmap.", "parameters.local_costmap."

_FRAMES = "frames are named in amcl or grid_slam"
_LAYERS = "the layers are the map, the obstacles that scans show, people, zones, and the octomap of the map"
_SCANS = "obstacles are what the scans of the robot show, whatever the topic"
_PLANE = "scans are projected to the ground; heights are those of voxel_layer, for the octomap of a map"
_WINDOW = "the local costmap moves with the robot, and the global one is the map"
_UPDATES = "costmaps change with each scan"
_STALE = "scans and poses may be as old as move_base's transform_tolerance, which a cloud needs longer"


def _without(reason: str, *names: str) -> dict[str, ParameterRule]:
    return {name: ParameterRule(text=reason) for name in names}


def outline(value: Any) -> list[list[float]]:
    """Return the corners of a footprint, which may be text.

    Raises
    ------
    InvalidParameter
        It is no list of at least three corners.
    """
    corners = read_footprint(value)
    if not isinstance(corners, list):
        raise InvalidParameter(f"footprint must be a list of corners [[x, y], …] [m], not {value!r}")
    found = [[float(number) for number in corner] for corner in corners]
    if any(len(corner) != 2 for corner in found):
        raise InvalidParameter("a corner of a footprint must be two numbers: x, y [m]")
    check_corners(tuple((x, y) for x, y in found))
    return found


_SHOWN = f"at most {MAX_PUBLISH_FREQUENCY:g} Hz"


def _published(value: Any) -> float:
    return min(float(value), MAX_PUBLISH_FREQUENCY)


EITHER: ParameterRules = {
    **_without(_FRAMES, "global_frame", "robot_base_frame"),
    **_without(_UPDATES, "update_frequency", "subscribe_to_updates", "always_send_full_costmap"),
    **_without(_LAYERS, "plugins", "map_type", "layers", "name", "type", "enabled", "combination_method",
               "use_maximum", "inflate_unknown"),
    **_without(_WINDOW, "static_map", "rolling_window", "first_map_only", "map_topic", "origin_x", "origin_y",
               "resolution", "trinary_costmap", "unknown_cost_value"),
    **_without(_SCANS, "observation_sources", "sensor_frame", "data_type", "topic", "marking", "clearing",
               "observation_persistence", "expected_update_rate", "observation_topic", "inf_is_valid",
               "footprint_clearing_enabled"),
    **_without(_PLANE, "max_obstacle_height", "min_obstacle_height", "origin_z", "z_resolution", "z_voxels",
               "unknown_threshold", "mark_threshold", "publish_voxel_map"),
    "transform_tolerance": ParameterRule(text=_STALE),
    "restore_defaults": ParameterRule(text="it belongs to dynamic_reconfigure"),
}  # fmt: skip
"""Rules without effect in either costmap, for their layers and sources, too."""

_OUTLINE: ParameterRules = {
    "robot_radius": ParameterRule(GLOBAL + "robot_radius"),
    "footprint": ParameterRule(GLOBAL + "footprint", convert=outline),
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
    **_without(_WINDOW, "width", "height"),
    **_without("obstacles are remembered beyond the local costmap as they are in it", "obstacle_range",
               "raytrace_range"),
}  # fmt: skip
"""Rules of the global costmap."""

LOCAL_RULES: ParameterRules = {
    **EITHER,
    **_OUTLINE,
    **{
        name: ParameterRule(LOCAL + name)
        for name in (
            "width", "height", "inflation_radius", "cost_scaling_factor", "obstacle_range", "raytrace_range",
        )
    },
    "publish_frequency": ParameterRule(LOCAL + "publish_frequency", _SHOWN, _published),
    **_without("the map of the robot file decides", "lethal_cost_threshold", "track_unknown_space"),
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
