"""What carries out the verdicts in a container: takes nodes out of its graph, and puts them in again."""

from collections.abc import Callable, Mapping
from typing import Protocol

import msgspec

from engine.specs.containers import RobotConfig
from ppaas.messages import decode
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.base import Checkpoint, Demands
from ppaas.nodes.graph import Graph
from ppaas.nodes.topic_bus import Tap


class Hands(Protocol):
    """What the node monitor can do with the nodes of its home."""

    config: str
    """What the nodes are made of, as JSON."""

    def nodes(self) -> Mapping[str, Demands | None]:
        """Return all nodes of the clone, wherever they run, and what they demand."""
        ...

    def take_out(self, node: str, came: Tap) -> str:
        """Let a node leave; return its checkpoint. ``came`` is told what must arrive at it, until it is put in."""
        ...

    def put_in(self, node: str, state: str) -> None:
        """Let a node go on here."""
        ...

    def tell(self, node: str, message: TopicMessage) -> None:
        """Tell a node what came for it while it was away."""
        ...

    def run_times(self) -> Mapping[str, float]:
        """Return what each node took here since the last call of this for each thing that it was told [s]."""
        ...


class GraphHands:
    """Hands for the graph of a container.

    Parameters
    ----------
    graph : Graph
        With the whole clone in it.
    robot : RobotConfig
        Whose clone it is.
    build : callable
        Adds a node to the graph by its name, as it was built at first.
    changed : callable
        Called when nodes have come or gone.
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
        """Return all nodes of the clone, wherever they run, and what they demand."""
        return self._nodes

    def take_out(self, node: str, came: Tap) -> str:
        """Let a node leave; return its checkpoint. ``came`` is told what must arrive at it, until it is put in."""
        subscribes = self._graph.nodes[node].subscribes if node in self._graph.nodes else ()
        state = self._graph.remove(node)
        self._untap[node] = [self._graph.tap(topic.name, came) for topic in subscribes if not topic.stream]
        self._changed()
        return (state or b"").decode()

    def put_in(self, node: str, state: str) -> None:
        """Let a node go on here."""
        for untap in self._untap.pop(node, ()):
            untap()
        self._build(node)
        if state:
            self._graph.restore([Checkpoint(node, state.encode())])
        self._changed()

    def tell(self, node: str, message: TopicMessage) -> None:
        """Tell a node what came for it while it was away."""
        kind = self._graph.topic(message.topic).type
        self._graph.deliver_to(node, message.topic, decode(kind, message.message.encode()))

    def run_times(self) -> Mapping[str, float]:
        """Return what each node took here since the last call of this for each thing that it was told [s]."""
        return {node: seconds / count for node, (count, seconds) in self._graph.times.take().items()}
