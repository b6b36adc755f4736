"""The node monitor, put into a container."""

from collections.abc import Callable, Sequence

import msgspec

from engine.container.monitor.measurements import Rates
from engine.container.monitor.node import NodeMonitorNode
from engine.container.monitor.node_switch import GraphHands
from engine.container.monitor.parameters import NAME, monitor_parameters
from engine.specs.containers import RobotConfig
from ppaas.nodes.graph import Graph


class Monitoring:
    """Holds what a container and the node monitor of its clone tell each other.

    Parameters
    ----------
    graph : Graph
        With the clone in it; the node monitor is added.
    robot : RobotConfig
        Whose clone it is.
    build : callable
        Adds nodes of the clone to the graph by their names, as they were built at first.

    Attributes
    ----------
    changed : callable
        Called when nodes have come or gone.

    Raises
    ------
    InvalidParameter
        What the robot's file says of the node monitor cannot be.
    """

    def __init__(self, graph: Graph, robot: RobotConfig, build: Callable[[Sequence[str]], None]) -> None:
        self.changed: Callable[[], None] = lambda: None
        self.rates = Rates()
        parameters = monitor_parameters(robot.parameters.get(NAME, {}))
        hands = GraphHands(graph, of_clone(robot), lambda node: build((node,)), self._nodes_changed)
        graph.add(lambda context: NodeMonitorNode(context, hands, self.rates, parameters))

    def _nodes_changed(self) -> None:
        self.changed()


def of_clone(robot: RobotConfig) -> RobotConfig:
    """Return what the other nodes must know of a robot: all but the parameters of the node monitor."""
    others = {name: values for name, values in robot.parameters.items() if name != NAME}
    return msgspec.structs.replace(robot, parameters=others)
