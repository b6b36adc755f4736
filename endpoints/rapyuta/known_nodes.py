"""Nodes of ROS 1 that a robot may start in a container, and the nodes of a clone that stand for them.

A clone has its nodes from the start, by the robot's file; nothing of another package is executed.
"""

import shlex
from collections.abc import Collection
from dataclasses import dataclass, field

from ppaas.errors import InvalidInput, NotFound
from ppaas.wire.rapyuta.requests import AddNode

NODES: dict[tuple[str, str], str] = {
    ("amcl", "amcl"): "amcl",
    ("move_base", "move_base"): "move_base",
    ("map_server", "map_server"): "map_server",
    ("gmapping", "slam_gmapping"): "grid_slam",
    ("slam_gmapping", "slam_gmapping"): "grid_slam",
    ("slam_karto", "slam_karto"): "grid_slam",
    ("hector_mapping", "hector_mapping"): "grid_slam",
    ("depthimage_to_laserscan", "depthimage_to_laserscan"): "depthimage_to_laserscan",
    ("octomap_server", "octomap_server_node"): "octomap_server",
    ("leg_detector", "leg_detector"): "leg_detector",
    ("explore", "explore"): "explore",
    ("explore_lite", "explore"): "explore",
    ("robot_state_publisher", "robot_state_publisher"): "robot_state_publisher",
    ("robot_state_publisher", "state_publisher"): "robot_state_publisher",
    ("tf2_web_republisher", "tf2_web_republisher"): "tf2_web_republisher",
}
"""Nodes of clones by package and executable."""

ON_REQUEST = frozenset({"depthimage_to_laserscan", "octomap_server", "leg_detector"})
"""Nodes that a clone has if the robot's file has parameters for them, which may be empty."""

SECTIONS = {"slam_gmapping": "grid_slam", "gmapping": "grid_slam", "slam_karto": "grid_slam"}
"""Names of nodes in ROS 1 whose parameters belong to another node here."""

_ASSIGNMENT = ":="


def node_of(pkg: str, exe: str, has: Collection[str]) -> str:
    """Return the node that stands for an executable.

    Parameters
    ----------
    pkg, exe : str
        Package and executable.
    has : collection of str
        Nodes that the clone has.

    Raises
    ------
    NotFound
        Nothing stands for it, or the clone lacks the node; the text lists what the clone has.
    """
    node = NODES.get((pkg, exe))
    known = [f"{package} {name}" for (package, name), one in NODES.items() if one in has or one in ON_REQUEST]
    if node is None or (node not in has and node not in ON_REQUEST):
        raise NotFound("node", f"{pkg} {exe}"[:128], known)
    return node


@dataclass(frozen=True, slots=True)
class NodeArguments:
    """Arguments of a node: private parameters as text, new names of topics by their old ones, and its own name."""

    parameters: dict[str, str] = field(default_factory=dict)
    remapped: dict[str, str] = field(default_factory=dict)
    name: str = ""
    namespace: str = ""


def parse_arguments(node: AddNode) -> NodeArguments:
    """Return the arguments of a node as ``rosrun`` reads them; files and flags have no meaning here and are left out.

    Raises
    ------
    InvalidInput
        A quotation in them does not end.
    """
    try:
        words = shlex.split(node.args)
    except ValueError as error:
        raise InvalidInput(f"the args of node {node.nodeTag!r} can not be read: {error}") from error
    pairs = [(left, right) for left, sep, right in (word.partition(_ASSIGNMENT) for word in words) if sep and left]
    special = {left: right for left, right in pairs if left.startswith("__")}
    parameters = {left[1:]: right for left, right in pairs if left.startswith("_") and not left.startswith("__")}
    remapped = {left.strip("/"): right.strip("/") for left, right in pairs if not left.startswith("_")}
    name = (node.name or special.get("__name", "")).strip("/")
    return NodeArguments(parameters, remapped, name, (node.namespace or special.get("__ns", "")).strip("/"))
