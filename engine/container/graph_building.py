"""Builds the graph of a container: the nodes of a clone and their monitor, or planning on a map."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from engine.container.monitor.setup import ContainerMonitor, of_clone
from engine.specs.containers import Launch
from engine.specs.layer_files import open_layers
from ppaas.clone.assembly import build_clone
from ppaas.clone.planning_container import build_planning
from ppaas.costmap.costmap import Indexes
from ppaas.costmap.map_layers import MapLayers
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.thread_budget import Threads


def build_graph(
    graph: Graph, launch: Launch, threads: Threads, indexes: Indexes | None = None, reuse: ReuseSetup | None = None
) -> ContainerMonitor | None:
    """Add the nodes of this container to its graph.

    Parameters
    ----------
    graph : Graph
        Graph of the container, still empty.
    launch : Launch
        Specification of the container, and the folder of its layers.
    threads : callable
        Returns the number of threads that kernels may use.
    indexes : callable, optional
        Returns the indexes of planners for the map.
    reuse : ReuseSetup, optional
        Access to the stored plans of the map. A robot that makes a new map uses none.

    Returns
    -------
    Monitoring or None
        The node monitor of a clone; None if the container only plans.
    """
    robot = launch.spec.robot
    layers = None if launch.spec.maps else _layers(launch, indexes)
    if robot is None:
        assert layers is not None
        build_planning(graph, layers, threads=threads, reuse=reuse)
        return None
    bare = of_clone(robot)
    text = UrdfText(robot.urdf_text) if robot.urdf_text else None

    def build(only: Sequence[str] | None = None) -> None:
        build_clone(
            graph,
            layers,
            model=bare.model,
            urdf=bare.urdf,
            urdf_text=text,
            initial_pose=bare.initial_pose,
            base_global_planner=bare.base_global_planner,
            base_local_planner=bare.base_local_planner,
            parameters=bare.parameters,
            threads=threads,
            reuse=None if layers is None else reuse,
            only=only,
        )

    build()
    return ContainerMonitor(graph, robot, build)


def _layers(launch: Launch, indexes: Indexes | None) -> MapLayers:
    layers = open_layers(Path(launch.layers))
    return replace(layers, costmap=replace(layers.costmap, indexes=indexes))
