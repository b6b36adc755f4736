"""Clones of all kinds, whose nodes the reference lists."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from engine.container.monitor.node import NodeMonitorNode
from ppaas.clone.assembly import build_clone
from ppaas.clone.people_coordination import build_coordinator
from ppaas.clone.traffic import build_traffic
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.nodes.base import Node, Topic
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.footprint.node import FootprintNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.recorder.node import RecorderNode
from ppaas.people.settings import PeopleSettings

KINDS: Mapping[str, Mapping[str, Any]] = {
    "a robot on a map": {},
    "a robot whose laser has several echoes": {"laser_proc": {}},
    "a robot that makes a map": {"depthimage_to_laserscan": {}},
    "a robot that sees and follows people": {"torso_detector": {}, "leg_detector": {}, "follow_person": {}},
    "a robot in the traffic": {"traffic": {}},
    "a robot that follows paths itself": {"follow_path": {}},
}
"""Kinds of robots, with the parameters that make a clone one of that kind."""

OF_CONTAINERS = (DiagnosticsNode, FootprintNode, NodeMonitorNode, RecorderNode)
"""Nodes that the container of each robot adds to its clone."""

MAKES_A_MAP = "a robot that makes a map"


def layers() -> MapLayers:
    """Return the layers of an empty map of two metres."""
    return build_layers(GridMap(np.zeros((40, 40), np.int8), GridInfo(0.05, 40, 40)), robot_radius=0.18)


def clone(kind: str, **parameters: Mapping[str, Any]) -> Graph:
    """Return a clone of a kind of robot, with more parameters."""
    graph = Graph()
    build_clone(
        graph,
        None if kind == MAKES_A_MAP else layers(),
        model="turtlebot2",
        initial_pose=(1.0, 1.0, math.pi / 2.0),
        parameters={**KINDS[kind], **parameters},
    )
    return graph


@dataclass(frozen=True)
class Member:
    """A node of a container.

    Parameters
    ----------
    of : str
        What the container is for.
    name : str
        Name of the node.
    node : Node or type of Node
        It, or its class, which declares the same topics and services.
    """

    of: str
    name: str
    node: Node | type[Node]

    @property
    def topics(self) -> dict[str, Topic]:
        """Topics of the node by name."""
        return {topic.name: topic for topic in (*self.node.publishes, *self.node.subscribes)}


def members() -> list[Member]:
    """Return the nodes of all kinds of clones, and of containers that serve groups of robots."""
    people, traffic = Graph(), Graph()
    build_coordinator(people, layers(), PeopleSettings())
    build_traffic(traffic, layers())
    graphs = {kind: clone(kind) for kind in KINDS} | {"the people of a map": people, "the traffic of a map": traffic}
    found = [Member(kind, name, node) for kind, graph in graphs.items() for name, node in graph.nodes.items()]
    return found + [Member(kind, node.name, node) for kind in KINDS for node in OF_CONTAINERS]
