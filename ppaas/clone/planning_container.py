"""Assembly of a container that only plans."""

from ppaas.clone.plugins import DEFAULT_PLANNER
from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.base import Context
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.node import MapServerNode
from ppaas.nodes.planner_server.node import PlannerServerNode
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.robot_model.known_models import PLANNING_MODEL, robot_model
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
    processor = (reuse or ReuseSetup()).processor(layers.costmap, robot_model(PLANNING_MODEL).robot_radius)

    def planner_server(context: Context) -> PlannerServerNode:
        return PlannerServerNode(context, layers.costmap, base_global_planner, threads, processor=processor)

    graph.add(lambda context: MapServerNode(context, layers))
    graph.add(planner_server)
