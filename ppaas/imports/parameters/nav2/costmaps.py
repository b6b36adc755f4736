"""Parameters of ``local_costmap`` and ``global_costmap``, with their layers and filters."""

from ppaas.clone.surroundings import MAX_PUBLISH_FREQUENCY
from ppaas.imports.parameters.nav2.reasons import SHOWN, TRANSFORMS, TYPES
from ppaas.imports.parameters.nav2.tables import NodeTable, PluginGroup, PluginTable, rules_of
from ppaas.imports.parameters.outline_rules import OUTLINE_RULES
from ppaas.imports.parameters.rules import without_effect
from ppaas.imports.parameters.values import at_most, flag, number, whole

OF_MAP = "the static layer has the cells, the origin and the values of the map"
OF_LOCAL = "local_costmap has the layer of what the laser sees"
OF_GLOBAL = "global_costmap has it"
ALL_LASERS = "a robot publishes all its scans on the topic scan"
AS_SEEN = "the layer takes the scans of all lasers, cleared and marked together"
AT_ONCE = "the costmap follows each scan and each pose"
MASKS = "publish the mask as a map, and name it in the robot file: parameters.{}.filter_mask"

_OF_SOURCE = without_effect(ALL_LASERS, "topic sensor_frame data_type transport_type") | without_effect(
    AS_SEEN,
    "observation_persistence expected_update_rate min_obstacle_height max_obstacle_height inf_is_valid marking "
    "clearing obstacle_min_range raytrace_min_range tf_filter_tolerance enabled",
)

LOCAL_SOURCE = _OF_SOURCE | rules_of(
    "local_costmap",
    "obstacle_range raytrace_range",
    {"obstacle_max_range": ("obstacle_range", number), "raytrace_max_range": ("raytrace_range", number)},
    convert={"obstacle_range": number, "raytrace_range": number},
)

GLOBAL_SOURCE = _OF_SOURCE | without_effect(
    OF_LOCAL, "obstacle_max_range raytrace_max_range obstacle_range raytrace_range"
)

_OUTSIDE = PluginTable(
    "",
    _OF_SOURCE
    | without_effect(
        "sources count below their layer", "obstacle_max_range raytrace_max_range obstacle_range raytrace_range"
    ),
)
"""Source of observations outside any layer, as in Dashing."""

_OBSTACLE = (
    "enabled footprint_clearing_enabled min_obstacle_height max_obstacle_height combination_method "
    "tf_filter_tolerance observation_sources track_unknown_space transform_tolerance publish_voxel_map origin_z "
    "z_resolution z_voxels unknown_threshold mark_threshold"
)

INFLATION_NONE = "inflate_unknown inflate_around_unknown enabled num_threads"


def _inflation(node: str) -> PluginTable:
    return PluginTable(
        "nav2_costmap_2d::InflationLayer",
        rules_of(
            node,
            "inflation_radius cost_scaling_factor",
            {},
            {"obstacles alone are inflated": INFLATION_NONE},
            {"inflation_radius": number, "cost_scaling_factor": number},
        ),
    )


def _layers(node: str) -> tuple[PluginTable, ...]:
    sources = LOCAL_SOURCE if node == "local_costmap" else GLOBAL_SOURCE
    legacy = PluginTable("nav2_costmap_2d::LegacyInflationLayer", _inflation(node).rules)
    return (
        _inflation(node),
        legacy,
        PluginTable("nav2_costmap_2d::ObstacleLayer", without_effect(AS_SEEN, _OBSTACLE), sources=sources),
        PluginTable("nav2_costmap_2d::VoxelLayer", without_effect(AS_SEEN, _OBSTACLE), sources=sources),
        *OTHER_LAYERS,
    )


STATIC = PluginTable(
    "nav2_costmap_2d::StaticLayer",
    without_effect(
        "the clone has the map of its robot",
        "enabled footprint_clearing_enabled subscribe_to_updates map_subscribe_transient_local transform_tolerance "
        "map_topic restore_cleared_footprint inscribed_obstacle_cost_value",
    ),
)

ASYMMETRIC = PluginTable(
    "nav2_costmap_2d::AsymmetricInflationLayer",
    without_effect(
        "obstacles are inflated on all sides alike",
        "enabled inflation_radius cost_scaling_factor_left cost_scaling_factor_right inflate_around_unknown "
        "plan_topic goal_distance_threshold cost_scaling_factor",
    ),
)

OTHER_LAYERS = (
    STATIC,
    ASYMMETRIC,
    PluginTable(
        "nav2_costmap_2d::RangeSensorLayer",
        without_effect(
            "sonars are not used: publish their readings as scans",
            "enabled topics phi inflate_cone no_readings_timeout clear_threshold mark_threshold clear_on_max_reading "
            "input_sensor_type max_angle use_decay pixel_decay transform_tolerance",
        ),
    ),
    PluginTable(
        "nav2_costmap_2d::DenoiseLayer",
        without_effect(AS_SEEN, "enabled minimal_group_size group_connectivity_type"),
    ),
    PluginTable(
        "nav2_costmap_2d::PluginContainerLayer",
        without_effect("layers in a container are not imported: list them in plugins", "enabled plugins"),
    ),
    PluginTable(
        "nav2_costmap_2d::TrackingBoundsLayer",
        without_effect(
            "paths have no corridor",
            "enabled tracking_feedback_topic path_topic look_ahead step corridor_width wall_thickness",
        ),
    ),
    PluginTable(
        "spatio_temporal_voxel_layer::SpatioTemporalVoxelLayer",
        without_effect(
            "the layer takes the scans of all lasers; octomap_server takes clouds",
            "enabled voxel_decay decay_model voxel_size track_unknown_space unknown_threshold mark_threshold "
            "update_footprint_enabled combination_method obstacle_range max_obstacle_height origin_z "
            "publish_voxel_map transform_tolerance mapping_mode map_save_duration observation_sources "
            "no_readings_timeout",
        ),
        sources=without_effect(
            ALL_LASERS,
            "data_type topic marking clearing obstacle_range min_obstacle_height max_obstacle_height "
            "expected_update_rate observation_persistence inf_is_valid filter voxel_min_points clear_after_reading "
            "max_z min_z vertical_fov_angle vertical_fov_padding horizontal_fov_angle decay_acceleration model_type "
            "voxel_filter enabled sensor_frame",
        ),
    ),
)

_FILTER = "filter_info_topic transform_tolerance"

KEEPOUT = PluginTable(
    "nav2_costmap_2d::KeepoutFilter",
    rules_of(
        "keepout_filter",
        "enabled",
        {},
        {
            MASKS.format("keepout_filter"): _FILTER,
            "cells of 100 are forbidden": "override_lethal_cost lethal_override_cost",
        },
        {"enabled": flag},
    ),
)

SPEED = PluginTable(
    "nav2_costmap_2d::SpeedFilter",
    rules_of(
        "speed_filter",
        "enabled",
        {},
        {MASKS.format("speed_filter"): f"{_FILTER} speed_limit_topic"},
        {"enabled": flag},
    ),
)

OTHER_FILTERS = (
    PluginTable(
        "nav2_costmap_2d::BinaryFilter",
        without_effect(
            "zones of a map may name actions instead",
            f"enabled {_FILTER} default_state binary_state_topic flip_threshold",
        ),
    ),
    PluginTable(
        "nav2_costmap_2d::ZoneParameterFilter",
        without_effect(
            "zones of a map have speeds, not parameters",
            f"enabled {_FILTER} state_event_topic states nominal_defaults",
        ),
    ),
)

_NONE = {
    OF_MAP: (
        "resolution origin_x origin_y rolling_window trinary_costmap unknown_cost_value use_maximum map_vis_z "
        "map_topic inscribed_obstacle_cost_value"
    ),
    AT_ONCE: "update_frequency initial_transform_timeout",
    TRANSFORMS: "transform_tolerance",
    SHOWN: "always_send_full_costmap",
    "amcl names the frames": "global_frame robot_base_frame",
    "the robot has one footprint": "subscribe_to_stamped_footprint clearable_layers layer_names",
    TYPES: "plugin_types",
}

_DEFAULTS = {
    "static_layer": "nav2_costmap_2d::StaticLayer",
    "obstacle_layer": "nav2_costmap_2d::ObstacleLayer",
    "inflation_layer": "nav2_costmap_2d::InflationLayer",
}


def _groups(node: str) -> tuple[PluginGroup, ...]:
    filters = (KEEPOUT, SPEED, *OTHER_FILTERS)
    return (
        PluginGroup(("plugins", "plugin_names"), (*_layers(node), *filters), _DEFAULTS),
        PluginGroup(("filters",), filters),
        PluginGroup(("observation_sources",), untyped=_OUTSIDE),
    )


LOCAL_COSTMAP = NodeTable(
    "local_costmap",
    rules_of(
        "local_costmap",
        "width height footprint_padding",
        {"publish_frequency": ("publish_frequency", at_most(MAX_PUBLISH_FREQUENCY))},
        {**_NONE, OF_GLOBAL: "track_unknown_space lethal_cost_threshold"},
        {"width": number, "height": number, "footprint_padding": number},
    )
    | OUTLINE_RULES,
    _groups("local_costmap"),
)

GLOBAL_COSTMAP = NodeTable(
    "global_costmap",
    rules_of(
        "global_costmap",
        "lethal_cost_threshold",
        {"track_unknown_space": ("static_layer.track_unknown_space", flag)},
        {
            **_NONE,
            "local_costmap has the padding": "footprint_padding",
            "the clone publishes the costmap when it changes": "publish_frequency",
            "the global costmap is as large as the map": "width height",
        },
        {"lethal_cost_threshold": whole},
    )
    | OUTLINE_RULES,
    _groups("global_costmap"),
)
