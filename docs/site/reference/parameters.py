"""Page of the parameters of nodes and plug-ins, with their defaults, from the classes that read them."""

import inspect
from collections.abc import Iterator
from typing import Any

import msgspec
from numpydoc.docscrape import NumpyDocString

from docs.site.reference.markdown import code, table
from docs.site.reference.markdown import page as joined
from engine.container.monitor.parameters import NodeMonitorParameters
from ppaas.clone.driving import DrivingInTraffic
from ppaas.clone.robot_body import COSTMAP, VOXEL_LAYER, VoxelLayerParameters
from ppaas.clone.surroundings import LocalCostmapParameters
from ppaas.controllers.registry import CONTROLLERS
from ppaas.costmap.global_parameters import GlobalCostmapParameters, StaticLayerParameters
from ppaas.docking.parameters import DockingParameters
from ppaas.exploration.parameters import ExploreParameters
from ppaas.localization.parameters import AmclParameters
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.teleoperation import TeleopParameters
from ppaas.nodes.follow_path.node import FollowPathParameters
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.laser_proc import LaserProcParameters
from ppaas.nodes.map_server.costmap_filters import KeepoutFilterParameters, SpeedFilterParameters
from ppaas.nodes.move_base.people import SocialLayerParameters
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters
from ppaas.nodes.people_tracker.parameters import PeopleTrackerParameters
from ppaas.nodes.tf.state_publisher import StatePublisherParameters
from ppaas.nodes.waypoint_follower.node import WaypointFollowerParameters
from ppaas.parameters import Parameters
from ppaas.people.following.parameters import FollowParameters
from ppaas.perception.depth_scan import DepthScanParameters
from ppaas.perception.legs.parameters import LegDetectorParameters
from ppaas.perception.torso.parameters import TorsoDetectorParameters
from ppaas.planners.registry import PLANNERS
from ppaas.plugins import PluginRegistry, parameters_in_use
from ppaas.recording.parameters import RecorderParameters
from ppaas.recoveries.registry import RECOVERIES

NODES: dict[str, type[Parameters]] = {
    "move_base": MoveBaseParameters,
    "docking_server": DockingParameters,
    "teleop": TeleopParameters,
    "amcl": AmclParameters,
    "grid_slam": GridSlamParameters,
    "octomap_server": OctomapServerParameters,
    "explore": ExploreParameters,
    "waypoint_follower": WaypointFollowerParameters,
    "robot_state_publisher": StatePublisherParameters,
    "depthimage_to_laserscan": DepthScanParameters,
    "laser_proc": LaserProcParameters,
    "torso_detector": TorsoDetectorParameters,
    "leg_detector": LegDetectorParameters,
    "people_tracker": PeopleTrackerParameters,
    "follow_person": FollowParameters,
    "follow_path": FollowPathParameters,
    "traffic": DrivingInTraffic,
    "recorder": RecorderParameters,
    "node_monitor": NodeMonitorParameters,
}
"""Parameters of nodes, by the name that a robot file gives them."""

COSTMAPS: dict[str, type[Parameters]] = {
    COSTMAP: GlobalCostmapParameters,
    "local_costmap": LocalCostmapParameters,
    "static_layer": StaticLayerParameters,
    "social_layer": SocialLayerParameters,
    VOXEL_LAYER: VoxelLayerParameters,
    "keepout_filter": KeepoutFilterParameters,
    "speed_filter": SpeedFilterParameters,
}
"""Parameters of the layers of costmaps."""

INTRODUCTION = """
Parameters that a [robot file](../robots.md) may have under `parameters`, by node and plug-in:
`{"move_base": {"planner_frequency": 2}, "dwa": {"sim_time": 2.0}}`. Unknown names and values out of range are refused.
Names are those of ROS where ROS has the parameter. A robot's model or URDF replaces the defaults of speeds, radius and
outline. `ppaas robot show ROBOT` prints what a robot's file gives; the service `/rosapi/get_param` returns what is in
use.
"""


def page() -> str:
    """Return the page."""
    return joined(
        "# Parameters",
        INTRODUCTION,
        "## Nodes",
        *_classes(NODES),
        "## Costmaps",
        *_classes(COSTMAPS),
        "## Planners",
        *_plugins(PLANNERS),
        "## Local planners",
        *_plugins(CONTROLLERS),
        "## Recovery behaviours",
        *_plugins(RECOVERIES),
    )


def _classes(classes: dict[str, type[Parameters]]) -> Iterator[str]:
    for name, cls in classes.items():
        yield f"### {code(name)}"
        yield prose(cls)
        yield fields_table(cls)


def _plugins(registry: PluginRegistry[Any]) -> Iterator[str]:
    for name in registry.names():
        plugin = registry.create(name, {})
        yield f"### {code(name)}"
        yield plugin.purpose
        aliases = ", ".join(map(code, registry.aliases(name)))
        yield f"Names in ROS: {aliases}." if aliases else ""
        parameters = getattr(plugin, "parameters", None)
        if isinstance(parameters, msgspec.Struct):
            yield fields_table(type(parameters))
        else:
            yield _arguments_table(plugin)


def fields_table(cls: type[msgspec.Struct]) -> str:
    """Return a table of the fields of a class, with their defaults and what its docstring says of each, if it does."""
    described = descriptions(cls)
    fields = msgspec.structs.fields(cls)
    rows = [(code(each.encode_name), code(_default(each)), described.get(each.encode_name, "")) for each in fields]
    if not described:
        return table(("parameter", "default"), (row[:2] for row in rows))
    return table(("parameter", "default", "meaning"), rows)


def _arguments_table(plugin: object) -> str:
    described = descriptions(type(plugin))
    rows = ((code(name), code(_json(value)), described.get(name, "")) for name, value in _in_use(plugin))
    return table(("parameter", "default", "meaning"), rows)


def _in_use(plugin: object) -> list[tuple[str, Any]]:
    return list(parameters_in_use(plugin).items())


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.default_factory is not msgspec.NODEFAULT:
        return _json(field.default_factory())
    return "" if field.default is msgspec.NODEFAULT else _json(field.default)


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode()


def prose(cls: type) -> str:
    """Return what the docstring of a class says besides the parameters, as Markdown."""
    found = _docstring(cls)
    return _markdown("\n".join([*found["Summary"], "", *found["Extended Summary"]]))


def descriptions(cls: type) -> dict[str, str]:
    """Return what the docstrings of a class and its bases say of each parameter, as Markdown."""
    return {
        name.strip(): _markdown(" ".join(entry.desc))
        for each in reversed(cls.__mro__[:-1])
        if each is not msgspec.Struct
        for entry in _docstring(each)["Parameters"]
        for name in entry.name.split(",")
    }


def _docstring(cls: type) -> NumpyDocString:
    return NumpyDocString(inspect.cleandoc(vars(cls).get("__doc__") or ""))


def _markdown(text: str) -> str:
    return text.replace("``", "`")
