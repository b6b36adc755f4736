"""Page of the parameters of ROS 1's navigation and of programs that make maps: what becomes of each of them."""

from collections.abc import Mapping

from docs.site.reference.import_rules import rule_table
from docs.site.reference.markdown import page as joined
from ppaas.imports.parameters.amcl_rules import ROS1_POSE, ROS1_RULES
from ppaas.imports.parameters.known_names import OF_ANY_NODE
from ppaas.imports.parameters.ros1.costmap_rules import COMMON_RULES, GLOBAL_RULES, LOCAL_RULES
from ppaas.imports.parameters.ros1.local_planner_rules import DYNAMIC_WINDOW, ELASTIC_BAND, TOP_SPEEDS, TRAJECTORY
from ppaas.imports.parameters.ros1.move_base_rules import CLEARING, GLOBAL_PLANNER, MOVE_BASE, NAVFN, ROTATING
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules
from ppaas.imports.parameters.slam.cartographer import RULES as CARTOGRAPHER
from ppaas.imports.parameters.slam.gmapping import RULES as GMAPPING
from ppaas.imports.parameters.slam.slam_toolbox_rules import LOCALIZATION_RULES, MAPPING_RULES

INTRODUCTION = """
What `ppaas robot put` does with each parameter of move_base, its costmaps, planners and recovery behaviours, of amcl
([I come from ROS 1 navigation](../from-ros1.md)), and of slam_toolbox, gmapping and cartographer ([I come from
slam_toolbox, gmapping or cartographer](../from-slam-toolbox.md)). A place in the robot file means that a parameter is
taken or translated; names without effect are in one row for each reason.
"""

_POSE = ParameterRule("initial_pose", "x, y [m] and yaw [rad]")
_PLANNER = ParameterRule("base_local_planner", "see the names of plug-ins")
_SPEED = ParameterRule("parameters.dwa.max_vel_x", "if it is lower; TebLocalPlannerROS sets parameters.mppi.max_vel_x")
_MODE = {
    "mode": ParameterRule("parameters.grid_slam.mode", "or amcl for localization, and lifelong by its parameters"),
    "map_file_name": ParameterRule(text="refused: a file of the robot's disk; name a published map"),
    "map_start_pose": ParameterRule("initial_pose", "of a robot that is localized"),
    "map_start_at_dock": ParameterRule(text="a map is continued from its first key frame, unless a pose is given"),
}

TABLES: Mapping[str, ParameterRules] = {
    "move_base": {"base_local_planner": _PLANNER, **MOVE_BASE},
    "TrajectoryPlannerROS": TRAJECTORY,
    "DWAPlannerROS": {**DYNAMIC_WINDOW, **dict.fromkeys(TOP_SPEEDS, _SPEED)},
    "TebLocalPlannerROS": {**ELASTIC_BAND, **dict.fromkeys(TOP_SPEEDS, _SPEED)},
    "NavfnROS": NAVFN,
    "GlobalPlanner": {**GLOBAL_PLANNER, "use_dijkstra": ParameterRule("base_global_planner", "dijkstra or astar")},
    "Costmaps, common": COMMON_RULES,
    "global_costmap": GLOBAL_RULES,
    "local_costmap": LOCAL_RULES,
    "clear_costmap_recovery": CLEARING,
    "rotate_recovery": ROTATING,
    "amcl": {**ROS1_RULES, **dict.fromkeys(ROS1_POSE, _POSE)},
    "slam_toolbox, mapping": {**_MODE, **MAPPING_RULES},
    "slam_toolbox, localization": LOCALIZATION_RULES,
    "gmapping": GMAPPING,
    **{f"cartographer, {name}": rules for name, rules in CARTOGRAPHER.items()},
    "All nodes": OF_ANY_NODE,
}
"""Rules by the headings of the page."""


def page() -> str:
    """Return the page."""
    parts = [part for heading, rules in TABLES.items() for part in (f"## {heading}", rule_table(rules))]
    return joined("# Parameters of ROS 1 and of mapping programs", INTRODUCTION, *parts)
