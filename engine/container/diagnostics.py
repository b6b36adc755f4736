"""Adds the node ``diagnostics`` to the clone of a robot."""

from engine.container.current_map import CurrentMap
from engine.specs.containers import RobotConfig
from engine.specs.robot_frames import frame_names
from ppaas.clone.assembly import DEPTH_CAMERA
from ppaas.clone.follow_path import FOLLOW_PATH
from ppaas.clone.robot_body import robot_body
from ppaas.diagnosis.observations.traffic import Traffic
from ppaas.diagnosis.observations.watched_robot import WatchedRobot
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.graph import Graph


def add_diagnostics(graph: Graph, robot: RobotConfig, current: CurrentMap, traffic: Traffic) -> None:
    """Add the node ``diagnostics`` to a graph with the clone of a robot.

    Parameters
    ----------
    graph : Graph
    robot : RobotConfig
        Configuration of the robot, which the clone has accepted.
    current : CurrentMap
        Its map, which may be replaced later.
    traffic : Traffic
        Counts of the messages that the container receives.
    """
    body = robot_body(robot.model, robot.urdf, robot.parameters)
    watched = WatchedRobot(
        id=robot.id,
        names=frame_names(robot),
        layers=lambda: current.layers,
        makes_map=bool(robot.new_map),
        camera=DEPTH_CAMERA in robot.parameters,
        follows_paths=FOLLOW_PATH in robot.parameters,
        radius=body.robot_radius if body.inner_radius is None else body.inner_radius,
    )
    graph.add(lambda context: DiagnosticsNode(context, graph, traffic, watched))
