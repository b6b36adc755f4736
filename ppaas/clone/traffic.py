"""Assembly of a container that grants the robots of a map how far they may drive."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from ppaas.costmap.map_layers import MapLayers
from ppaas.fleet.lane_roadmap import roadmap_on
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.robot_sizes import RobotSizes, clearance_of
from ppaas.nodes.graph import Graph
from ppaas.nodes.traffic.node import TrafficNode
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.sizes import MakeRoadmap


def build_traffic(graph: Graph, layers: MapLayers) -> None:
    """Add the node of a container of the traffic of a map.

    Parameters
    ----------
    graph : Graph
        Graph of the executor.
    layers : MapLayers
        The map.
    """
    graph.add(lambda context: TrafficNode(context, roadmaps_of, layers, TrafficParameters()))


def roadmaps_of(layers: MapLayers) -> MakeRoadmap:
    """Return the function that makes the roadmaps of a map for robots of some radii [m] and margins.

    They lead along the lanes of the map, or over all of it if it has none. They are made without its other zones, which
    change while robots drive.
    """
    return partial(_roadmap, layers)


def _roadmap(layers: MapLayers, radii: Sequence[float], margins: TrafficParameters) -> MetricRoadmap:
    largest, bare = max(radii), replace(layers, barred_distance=None)
    clearance = largest + margins.margin + margins.wall_margin
    sizes = RobotSizes(largest, margins.margin, clearance=clearance, smaller=radii)
    return roadmap_on(clearance_of(bare), layers.grid.info, layers.zones.zones, sizes)
