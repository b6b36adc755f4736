"""Small mappings: key frames on a tour through a room, with their pose graph."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frame_graph import append_key_frame
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import relative
from tests.support.world.room_scans import LASER, scan_at

INFORMATION = np.array((2e4, 10.0, -20.0, 1e4, 5.0, 1e5))
"""Information of a tracked pose [1/m², 1/rad²]."""


def room_mapping(count: int, laser: LaserGeometry = LASER, closures: int = 0) -> Mapping:
    """Return a mapping of a room.

    Parameters
    ----------
    count : int
        Number of key frames; at their true poses, on a circle of 1 m that takes 40 of them.
    laser : LaserGeometry
    closures : int
        Number of edges between key frames 40 apart.
    """
    frames, graph = KeyFrames(laser), PoseGraph()
    for _ in range(count):
        extend_tour(frames, graph)
    for first in range(closures):
        graph.add_edge(
            first, first + 40, relative(*frames.poses[[first, first + 40]]), 1e3 * np.eye(3), EdgeKind.CLOSURE
        )
    return Mapping(frames, graph, "laser")


def extend_tour(frames: KeyFrames, graph: PoseGraph) -> None:
    """Append the next key frame of the tour."""
    k = len(frames)
    angle = 2.0 * np.pi * k / 40
    pose = Pose2D(np.cos(angle), np.sin(angle) - 1.0, (angle + np.pi / 2.0 + np.pi) % (2.0 * np.pi) - np.pi)
    frames.add(scan_at(pose, frames.geometry, noise=0.01, seed=k), 3 * k, pose, INFORMATION * (k > 0))
    append_key_frame(graph, frames)
