"""All nodes of Nav2 that are known, by name, and the parameters that are no rules of a table."""

from ppaas.imports.parameters.amcl_rules import NAV2_RULES
from ppaas.imports.parameters.known_names import rule_of_any_node
from ppaas.imports.parameters.nav2.costmaps import GLOBAL_COSTMAP, LOCAL_COSTMAP
from ppaas.imports.parameters.nav2.other_nodes import FILTER_INFO, FILTER_INFO_SERVERS, OTHER_NODES
from ppaas.imports.parameters.nav2.servers import (
    BEHAVIOR_SERVER,
    BT_NAVIGATOR,
    CONTROLLER_SERVER,
    PLANNER_SERVER,
    VELOCITY_SMOOTHER,
    WAYPOINT_FOLLOWER,
)
from ppaas.imports.parameters.nav2.tables import NodeTable, rules_of
from ppaas.imports.parameters.rules import ParameterRule
from ppaas.imports.parameters.values import number, whole

SPEED_INFO = rules_of(
    "speed_filter",
    "type base multiplier",
    convert={"type": whole, "base": number, "multiplier": number},
)
"""Of a server of filter infos whose type is a speed filter."""

_FILTER_INFO_NODE = NodeTable(
    FILTER_INFO_SERVERS[0],
    FILTER_INFO | SPEED_INFO,
    also=FILTER_INFO_SERVERS[1:],
)

SMOOTHED = {
    "max_velocity": ParameterRule(
        "parameters.controller.max_vel_x", "the lower limit counts: max_vel_x and max_vel_theta"
    ),
    "min_velocity": ParameterRule("parameters.controller.min_vel_x", "the slower speed in reverse counts"),
    "max_accel": ParameterRule(
        "parameters.controller.acc_lim_x", "the lower limit counts: acc_lim_x and acc_lim_theta"
    ),
    "deadband_velocity": ParameterRule(
        "parameters.controller.min_vel_trans", "the higher threshold counts: min_vel_trans and min_vel_theta"
    ),
}
"""Limits of the velocity smoother, lists of x, y and theta."""

_SMOOTHER = NodeTable(VELOCITY_SMOOTHER.node, {**VELOCITY_SMOOTHER.rules, **SMOOTHED})

NODES = (
    NodeTable("amcl", NAV2_RULES), BT_NAVIGATOR, CONTROLLER_SERVER, PLANNER_SERVER, LOCAL_COSTMAP, GLOBAL_COSTMAP,
    BEHAVIOR_SERVER, _SMOOTHER, WAYPOINT_FOLLOWER, _FILTER_INFO_NODE, *OTHER_NODES,
)  # fmt: skip
"""In the order in which they are applied: the smoother's limits come after the controller's."""

BY_NAME = {name: table for table in NODES for name in (table.node, *table.also)}

FOREIGN = {
    "slam_toolbox": "ppaas robot put --slam-toolbox FILE takes the parameters of slam_toolbox",
    "ekf_filter_node": "the robot publishes its odometry itself",
    "robot_state_publisher": "ppaas robot urdf put takes the model of the robot",
    "joint_state_publisher": "ppaas robot urdf put takes the model of the robot",
    "world_model": "the clone has its costmaps itself",
    "twist_mux": "the robot chooses among its sources of commands itself",
}
"""Nodes that are no part of Nav2, and often in its files."""

INNER = ("_rclcpp_node", "_client")
"""Ends of the names of nodes that Nav2 had within its nodes."""


def rule_of(table: NodeTable, name: str) -> ParameterRule | None:
    """Return the rule of a parameter of a node, or of all nodes; None if it is unknown."""
    return table.rules.get(name) or rule_of_any_node(name)


def owner_of(table: NodeTable, name: str) -> str:
    """Return the plug-in of a node, or else another node, that knows a parameter; empty if none does."""
    plugins = (plugin for group in table.groups for plugin in group.tables)
    owner = next((plugin.plugin for plugin in plugins if name in plugin.rules), "")
    return owner or next((each.node for each in NODES if name in each.rules), "")
