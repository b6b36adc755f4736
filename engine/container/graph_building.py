"""Builds the graph of a container: nodes of a clone and their monitor, planning on a map, or the node of a group."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.container.carried_load import REASON, LoadFitting
from engine.container.current_map import CurrentMap
from engine.container.monitor.setup import ContainerMonitor, of_clone
from engine.container.recording import RecordingLink
from engine.specs.containers import ContainerSpec, Launch, RobotConfig, frame_names
from ppaas.clone.assembly import DEPTH_CAMERA, build_clone
from ppaas.clone.driving import FOLLOW_PATH
from ppaas.clone.localization import localizes_itself
from ppaas.clone.planning_container import build_planning
from ppaas.clone.robot_body import robot_body
from ppaas.costmap.map_layers import MapLayers
from ppaas.diagnosis.observations.place import WatchedRobot
from ppaas.diagnosis.observations.topic_table import TrafficCounter
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.footprint.node import FootprintNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.stop.node import StopNode
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.thread_budget import Threads
from storage.staged_uploads import mapped
from storage.versions import POSEGRAPH


@dataclass(frozen=True, slots=True)
class Attendants:
    """Parts of a container that attend to its clone: node monitor, link of the recorder, node of stops, its load."""

    monitoring: ContainerMonitor
    recording: RecordingLink
    stop: StopNode
    fitting: LoadFitting


def build_graph(graph: Graph, launch: Launch, threads: Threads, current: CurrentMap) -> Attendants | None:
    """Add the nodes of this container to its graph.

    Parameters
    ----------
    graph : Graph
        Graph of the container, still empty.
    launch : Launch
        Specification of the container.
    threads : callable
        Returns the number of threads that kernels may use.
    current : CurrentMap
        Its map, whose layers may be replaced later. A robot that makes a new map uses no stored plans.

    Returns
    -------
    Attendants or None
        The attendants of a clone; None if the container only plans, or has the node of a group.
    """
    robot = launch.spec.robot
    if robot is None:
        assert current.layers is not None
        if launch.spec.group_node:
            _build_group_node(graph, launch.spec, current.layers)
        else:
            build_planning(graph, current.layers, threads=threads, reuse=current.reuse)
        return None
    builder = CloneBuilder(graph, launch, threads, current)
    builder()
    monitoring = ContainerMonitor(graph, robot, builder)
    _add_diagnostics(graph, of_clone(robot), current, monitoring.traffic)
    stop = graph.add(lambda context: StopNode(context, graph, robot.id, launch.spec.stops))
    fitting = _add_footprint(graph, robot, current, builder, monitoring)
    return Attendants(monitoring, RecordingLink(graph, robot, current, launch.spec.cores), stop, fitting)


class CloneBuilder:
    """Builds nodes of a clone, for the map and the robot as they are now.

    Parameters
    ----------
    graph, launch, threads, current
        As of `build_graph`.
    """

    def __init__(self, graph: Graph, launch: Launch, threads: Threads, current: CurrentMap) -> None:
        self._graph, self._threads, self._current = graph, threads, current
        self._posegraph = Path(launch.layers) / POSEGRAPH

    def __call__(self, only: Sequence[str] | None = None) -> None:
        """Build the nodes with the given names, all by default, and add them to the graph."""
        current, robot = self._current, self._current.spec.robot
        assert robot is not None, "only the clone of a robot is built"
        bare = of_clone(robot)
        build_clone(
            self._graph,
            current.layers,
            model=bare.model,
            urdf=bare.urdf,
            urdf_text=UrdfText(robot.urdf_text) if robot.urdf_text else None,
            initial_pose=bare.initial_pose,
            base_global_planner=bare.base_global_planner,
            base_local_planner=bare.base_local_planner,
            parameters=bare.parameters,
            threads=self._threads,
            reuse=None if current.layers is None else current.reuse,
            only=only,
            posegraph=None if robot.continued is None else lambda _: memoryview(mapped(self._posegraph)),
            robot=bare.id,
        )


def _add_footprint(
    graph: Graph, robot: RobotConfig, current: CurrentMap, builder: CloneBuilder, monitoring: ContainerMonitor
) -> LoadFitting:
    """Add the node that knows what the robot carries, and fits the clone to it."""
    fitting = LoadFitting(graph, current, builder, monitoring)
    graph.add(lambda context: FootprintNode(context, graph, fitting.change, current.load, frame_names(robot)))
    if current.load:
        monitoring.keep_here(REASON)
    return fitting


def _build_group_node(graph: Graph, spec: ContainerSpec, layers: MapLayers) -> None:
    # Imported only here, so that other containers do not load what only the node of a group uses.
    if spec.people is not None:
        from ppaas.clone.people_coordination import build_coordinator  # noqa: PLC0415

        build_coordinator(graph, layers, spec.people)
    else:
        from ppaas.clone.traffic import build_traffic  # noqa: PLC0415

        build_traffic(graph, layers)


def _add_diagnostics(graph: Graph, robot: RobotConfig, current: CurrentMap, traffic: TrafficCounter) -> None:
    watched = WatchedRobot(
        id=robot.id,
        names=frame_names(robot),
        layers=lambda: current.layers,
        makes_map=bool(robot.new_map),
        camera=DEPTH_CAMERA in robot.parameters,
        follows_paths=FOLLOW_PATH in robot.parameters,
        localizes_itself=localizes_itself(robot.parameters),
        radius=lambda: _inner_radius(current.spec.robot or robot),
    )
    graph.add(lambda context: DiagnosticsNode(context, graph, traffic, watched))


def _inner_radius(robot: RobotConfig) -> float:
    body = robot_body(robot.model, robot.urdf, robot.parameters)
    return body.robot_radius if body.inner_radius is None else body.inner_radius
