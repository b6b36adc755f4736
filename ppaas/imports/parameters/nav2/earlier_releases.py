"""Names of Nav2's releases before Humble, as those since: nodes of one plug-in, and plug-ins listed beside their names.

Dashing has a node for its controller and one for its planner; Dashing and Eloquent list plug-ins and their names apart.
"""

from collections.abc import Mapping
from typing import NamedTuple

from ppaas.imports.parameters.nav2.catalogue import BY_NAME, rule_of
from ppaas.imports.parameters.nav2.controllers import DWB
from ppaas.imports.parameters.nav2.nodes import Values
from ppaas.imports.parameters.nav2.planners import NAVFN
from ppaas.imports.parameters.nav2.tables import PluginTable
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.values import names_of

_TYPES = {
    "plugin_names": "plugin_types",
    "controller_plugin_ids": "controller_plugin_types",
    "planner_plugin_ids": "planner_plugin_types",
}
"""Lists of plug-ins by the lists of their names."""

_PLUGIN_NODES: Mapping[str, tuple[str, str, PluginTable]] = {
    "dwb_controller": ("controller_server", "FollowPath", DWB),
    "DwbController": ("controller_server", "FollowPath", DWB),
    "navfn_planner": ("planner_server", "GridBased", NAVFN),
}
"""Today's node, section and plug-in of each node that was one plug-in."""

_TOLERANCES = ("xy_goal_tolerance", "yaw_goal_tolerance")


class RenamedNode(NamedTuple):
    """Parameters of a node as those of today's releases.

    Parameters
    ----------
    node : str
        Name of the node today.
    values : dict
        Values by their names today.
    shown : mapping of str to str
        Names in the file by the names today; empty for what the node itself says.
    """

    node: str
    values: Values
    shown: Mapping[str, str]


def as_today(node: str, values: Values) -> RenamedNode:
    """Return a node that was one plug-in as a section of today's node; other nodes as they are."""
    if node not in _PLUGIN_NODES:
        return RenamedNode(node, values, {})
    today, section, table = _PLUGIN_NODES[node]
    shown = {f"{section}.plugin": ""}
    found = {f"{section}.plugin": GivenValue(table.plugin, min(given.line for given in values.values()))}
    for name, given in values.items():
        full = _name_today(name, today, section, table)
        shown[full] = name
        found[full] = given
    return RenamedNode(today, found, shown)


def _name_today(name: str, node: str, section: str, table: PluginTable) -> str:
    if name in _TOLERANCES and table is DWB:
        return f"goal_checker.{name}"
    of_node = name not in table.rules and rule_of(BY_NAME[node], name) is not None
    return name if of_node else f"{section}.{name}"


def with_plugins(values: Values) -> Values:
    """Return the parameters of a node with the plug-in of each section that a list of plug-ins gives."""
    found = dict(values)
    for names, types in _TYPES.items():
        if names in values and types in values:
            given = values[types]
            for name, plugin in zip(names_of(values[names].value), names_of(given.value), strict=False):
                found.setdefault(f"{name}.plugin", GivenValue(plugin, given.line))
    return found
