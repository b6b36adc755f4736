"""Assembly of a container that coordinates the robots of a group that see people."""

from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.graph import Graph
from ppaas.nodes.people_coordinator.node import PeopleCoordinatorNode
from ppaas.people.coordinator.coordinator import PeopleCoordinator
from ppaas.people.settings import PeopleSettings


def build_coordinator(graph: Graph, layers: MapLayers, settings: PeopleSettings) -> None:
    """Add the node of a container that coordinates.

    Parameters
    ----------
    graph : Graph
        Graph of the executor.
    layers : MapLayers
        The map of the group, inflated for the planning model.
    settings : PeopleSettings
        Settings of the group.

    Raises
    ------
    NotFound
        The settings name a rule that is not installed.
    """
    coordinator = PeopleCoordinator(layers.costmap, settings)
    graph.add(lambda context: PeopleCoordinatorNode(context, coordinator))
