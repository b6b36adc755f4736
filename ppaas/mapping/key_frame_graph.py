"""Key frames as nodes of a pose graph, each joined with the one before."""

import numpy as np

from ppaas.mapping.edge_information import STEP_FLOOR, edge_information
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.planar_poses import PoseArray, relative


def append_key_frame(graph: PoseGraph, frames: KeyFrames) -> PoseArray:
    """Append the last key frame to a graph, and return its pose in the frame of the one before, zeros for the first.

    Parameters
    ----------
    graph : PoseGraph
        Modified: it has a node for each earlier key frame.
    frames : KeyFrames

    Returns
    -------
    (3,) array
        x, y [m], theta [rad].
    """
    node = graph.add_node(frames.poses[-1])
    step = np.zeros(3)
    if node:
        step = relative(frames.poses[node - 1], frames.poses[node])
        information = edge_information(step, frames.information[node], STEP_FLOOR)
        graph.add_edge(node - 1, node, step, information, EdgeKind.ODOMETRY)
    return step


def append_lost(graph: PoseGraph, frames: KeyFrames) -> PoseArray:
    """Append the last key frame to a graph as the first one of a part that no edge connects; return zeros (3,)."""
    graph.add_node(frames.poses[-1])
    return np.zeros(3)


def append_placed(graph: PoseGraph, frames: KeyFrames, nearest: int) -> None:
    """Append the last key frame to a graph, with an edge from another one that it was aligned with.

    Parameters
    ----------
    graph : PoseGraph
        Modified: it has a node for each earlier key frame.
    frames : KeyFrames
    nearest : int
        Index of the other key frame.
    """
    node = graph.add_node(frames.poses[-1])
    step = relative(frames.poses[nearest], frames.poses[node])
    information = edge_information(step, frames.information[node], STEP_FLOOR)
    graph.add_edge(nearest, node, step, information, EdgeKind.ODOMETRY)
