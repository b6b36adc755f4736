"""Assembly of a container that only plans."""

from ppaas.clone.planning_variants import PlanningVariants
from ppaas.clone.plugins import DEFAULT_PLANNER
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.base import Context
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.node import MapServerNode
from ppaas.nodes.planner_server.node import PlannerServerNode
from ppaas.nodes.planner_server.variants import Variants
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.thread_budget import Threads, one_thread


def build_planning(
    graph: Graph,
    layers: MapLayers,
    *,
    threads: Threads = one_thread,
    base_global_planner: str = DEFAULT_PLANNER,
    reuse: ReuseSetup | None = None,
) -> None:
    """Add the nodes of a container that only plans, for a robot of `PLANNING_MODEL`: map server and planner server."""
    setup = reuse or ReuseSetup()

    def surroundings_of(layers: MapLayers) -> tuple[Costmap, PlanProcessor, Variants]:
        variants = PlanningVariants(layers, setup)
        return *variants.usual, variants

    def planner_server(context: Context) -> PlannerServerNode:
        return PlannerServerNode(context, base_global_planner, threads, surroundings_of=surroundings_of, layers=layers)

    graph.add(lambda context: MapServerNode(context, layers))
    graph.add(planner_server)
