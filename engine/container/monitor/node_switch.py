"""Node switch: executes the verdicts in a container, by removing nodes from its graph and adding them again."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import msgspec

from engine.specs.containers import RobotConfig
from ppaas.change_log import LogChange, LogEntry
from ppaas.messages import decode
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.base import Checkpoint, Demands
from ppaas.nodes.graph import Graph
from ppaas.nodes.topic_bus import Tap


class NodeSwitch(Protocol):
    """Operations of the node monitor on the nodes of its graph."""

    config: str
    """Robot configuration from which the nodes are built, as JSON."""

    def nodes(self) -> Mapping[str, Demands | None]:
        """Return the demands of all nodes of the clone, in either home, by name."""
        ...

    def take_out(self, node: str, came: Tap) -> str:
        """Remove a node; return its checkpoint. Until ``put_in``, ``came`` is called with reliable messages for it."""
        ...

    def whole_log(self, node: str) -> LogChange | None:
        """Return all entries of a node's log, in place of those before; None if it has none."""
        ...

    def put_in(self, node: str, state: str, log: Sequence[LogEntry] = ()) -> None:
        """Add a node again, and restore it from its checkpoint and its log.

        Raises
        ------
        InvalidInput
            The node cannot read the checkpoint; it runs, in its initial state.
        """
        ...

    def tell(self, node: str, message: TopicMessage) -> None:
        """Deliver a message that arrived for a node while it was away."""
        ...

    def run_times(self) -> Mapping[str, float]:
        """Return the mean time of each node here to process one input since the last call [s]."""
        ...


class GraphNodeSwitch:
    """Switch for the nodes in the graph of a container.

    Parameters
    ----------
    graph : Graph
        Graph with the whole clone.
    robot : RobotConfig
        Configuration of the robot.
    build : callable
        Builds the node with the given name, and adds it to the graph.
    changed : callable
        Called when nodes were added or removed.
    """

    def __init__(
        self, graph: Graph, robot: RobotConfig, build: Callable[[str], None], changed: Callable[[], None]
    ) -> None:
        self.config = msgspec.json.encode(robot).decode()
        self._graph = graph
        self._build = build
        self._changed = changed
        self._nodes: dict[str, Demands | None] = {name: node.demands for name, node in graph.nodes.items()}
        self._untap: dict[str, list[Callable[[], None]]] = {}

    def nodes(self) -> Mapping[str, Demands | None]:
        """Return the demands of all nodes of the clone, in either home, by name."""
        return self._nodes

    def take_out(self, node: str, came: Tap) -> str:
        """Remove a node; return its checkpoint. Until ``put_in``, ``came`` is called with reliable messages for it."""
        subscribes = self._graph.nodes[node].subscribes if node in self._graph.nodes else ()
        state = self._graph.remove(node)
        self._untap[node] = [self._graph.tap(topic.name, came) for topic in subscribes if not topic.stream]
        self._changed()
        return (state or b"").decode()

    def whole_log(self, node: str) -> LogChange | None:
        """Return all entries of a node's log, in place of those before; None if it has none."""
        return self._graph.nodes[node].whole_log() if node in self._graph.nodes else None

    def put_in(self, node: str, state: str, log: Sequence[LogEntry] = ()) -> None:
        """Add a node again, and restore it from its checkpoint and its log.

        Raises
        ------
        InvalidInput
            The node cannot read the checkpoint; it runs, in its initial state.
        """
        for untap in self._untap.pop(node, ()):
            untap()
        self._build(node)
        self._changed()
        if state:
            self._graph.restore([Checkpoint(node, state.encode())])
        if log:
            self._graph.nodes[node].restore_log(log)

    def tell(self, node: str, message: TopicMessage) -> None:
        """Deliver a message that arrived for a node while it was away."""
        kind = self._graph.topic(message.topic).type
        self._graph.deliver_to(node, message.topic, decode(kind, message.message.encode()))

    def run_times(self) -> Mapping[str, float]:
        """Return the mean time of each node here to process one input since the last call [s]."""
        return {node: seconds / count for node, (count, seconds) in self._graph.times.take().items()}
