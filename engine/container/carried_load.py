"""Fits a clone to what its robot carries: the nodes that use its outline are built again, from their checkpoints."""

import asyncio
import logging
from collections.abc import Callable, Sequence

from engine.container.current_map import CurrentMap
from engine.container.monitor.setup import ContainerMonitor
from ppaas.clone.optional_nodes import EXPLORE
from ppaas.footprints import Footprint
from ppaas.nodes.base import Checkpoint
from ppaas.nodes.docking_server.node import DockingServerNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.parameter_server.node import ParameterServerNode

logger = logging.getLogger(__name__)

WITH_OUTLINE = (MoveBaseNode.name, DockingServerNode.name, EXPLORE, ParameterServerNode.name)
"""Nodes that are made with the outline of the robot; some containers lack one."""

REASON = "the robot carries a load, which its scans must not show"


class LoadFitting:
    """Fits the clone of a container to the load of its robot.

    Parameters
    ----------
    graph : Graph
        Graph with the clone.
    current : CurrentMap
        Its map, and its spec.
    build : callable
        Builds the nodes with the given names for the current spec, and adds them to the graph.
    monitoring : ContainerMonitor
        Node monitor of the clone: while the robot carries a load, all nodes run here.

    Attributes
    ----------
    fitted : callable
        Called after each change.
    """

    def __init__(
        self, graph: Graph, current: CurrentMap, build: Callable[[Sequence[str]], None], monitoring: ContainerMonitor
    ) -> None:
        self.fitted: Callable[[], None] = lambda: None
        self._graph, self._current, self._build, self._monitoring = graph, current, build, monitoring

    def change(self, load: Footprint) -> None:
        """Fit the clone to a load, or to none, once the nodes have handled the message that says so."""
        asyncio.get_running_loop().call_soon(self._fit, load)

    def _fit(self, load: Footprint) -> None:
        logger.info("the robot carries %s", f"a load with {len(load)} corners" if load else "nothing")
        self._monitoring.keep_here(REASON if load else "")
        self._current.carry(load, self._graph)
        for name in WITH_OUTLINE:
            if name in self._graph.nodes:
                state = self._graph.remove(name)
                self._build((name,))
                if state is not None:
                    self._graph.restore([Checkpoint(name, state)])
        self.fitted()
