"""Graph of the nodes of robots, with topics and services by the names that viewers use."""

from collections import defaultdict
from collections.abc import Iterable

from endpoints.foxglove.robot_view import RobotView
from engine.sessions.rosapi import view_of
from ppaas.wire.foxglove.answers import Graph

EMPTY = Graph({}, {}, {})


def graph_of(views: Iterable[RobotView]) -> Graph:
    """Return the graph of some robots."""
    published, subscribed, services = (defaultdict[str, list[str]](list) for _ in range(3))
    for view in views:
        for name, node in view_of(view.place).nodes.items():
            node_id = f"/{view.name}/{name}"
            for found, names in ((published, node.publishes), (subscribed, node.subscribes), (services, node.services)):
                for one in sorted(names):
                    found[f"/{view.name}/{one}"].append(node_id)
    return Graph(dict(published), dict(subscribed), dict(services))
