"""Setup of the node monitor in a container."""

from collections.abc import Callable, Sequence

import msgspec

from engine.container.monitor.leased_logs import LeasedLogs
from engine.container.monitor.measurements import TopicRates
from engine.container.monitor.node import NodeMonitorNode
from engine.container.monitor.node_switch import GraphNodeSwitch
from engine.container.monitor.parameters import NAME, monitor_parameters
from engine.specs.containers import RobotConfig
from ppaas.diagnosis.observations.topic_table import TrafficCounter
from ppaas.nodes.graph import Graph
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.topics import STOP_STATE
from ppaas.recording.parameters import NAME as RECORDER


class ContainerMonitor:
    """Connection between a container and the node monitor of its clone.

    Parameters
    ----------
    graph : Graph
        Graph with the clone; the node monitor is added to it.
    robot : RobotConfig
        Configuration of the robot.
    build : callable
        Builds the nodes with the given names, and adds them to the graph.

    Attributes
    ----------
    changed : callable
        Called when nodes were added or removed.
    rates : TopicRates
        Data rates of topics.
    traffic : TrafficCounter
        Counts of the messages that the container receives.

    Raises
    ------
    InvalidParameter
        A parameter of the node monitor in the robot's file is invalid.
    """

    def __init__(self, graph: Graph, robot: RobotConfig, build: Callable[[Sequence[str]], None]) -> None:
        self.changed: Callable[[], None] = lambda: None
        self.rates = TopicRates()
        self.traffic = TrafficCounter()
        parameters = monitor_parameters(robot.parameters.get(NAME, {}))
        switch = GraphNodeSwitch(graph, of_clone(robot), lambda node: build((node,)), self._nodes_changed)
        self._node = graph.add(lambda context: NodeMonitorNode(context, switch, self.rates, parameters))

    def recall(self, reason: str) -> None:
        """Continue all nodes that run on the robot here; the robot may take them again at once."""
        self._node.recall(reason)

    def keep_here(self, reason: str) -> None:
        """Run all nodes here for a reason; without one, let the robot take again those that it ran before."""
        self._node.keep_here(reason)

    @property
    def logs(self) -> LeasedLogs:
        """Logs of the nodes that the robot runs."""
        return self._node.logs

    def lacks_stops(self) -> bool:
        """Return whether the robot runs Move Base, or may, and has not confirmed whether it is stopped."""
        return self._node.lacks(MoveBaseNode.name, STOP_STATE.name)

    def _nodes_changed(self) -> None:
        self.changed()


def of_clone(robot: RobotConfig) -> RobotConfig:
    """Return the configuration for the other nodes: without parameters of node monitor and recorder, and the URDF."""
    others = {name: values for name, values in robot.parameters.items() if name not in (NAME, RECORDER)}
    return msgspec.structs.replace(robot, parameters=others, urdf_text=b"")
