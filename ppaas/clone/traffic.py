"""Assembly of a container that grants the robots of a map how far they may drive."""

from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.graph import Graph
from ppaas.nodes.traffic.node import TrafficNode


def build_traffic(graph: Graph, layers: MapLayers) -> None:
    """Add the node of a container of the traffic of a map.

    Parameters
    ----------
    graph : Graph
        Graph of the executor.
    layers : MapLayers
        The map.
    """
    del layers
    graph.add(TrafficNode)
