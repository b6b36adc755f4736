"""Mapping of a room that a robot goes round again and again, in which boxes are moved."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frame_graph import append_key_frame
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import Chosen, thin
from ppaas.mapping.scan_points import ScanPoints
from ppaas.planar_poses import relative
from tests.support.world.room_scans import ROOM, scan_at, segments

LASER = LaserGeometry(0.0, np.pi / 60.0, 120)

LAP = 30
"""Key frames of a lap, on a circle of 1 m around the origin."""

PARAMETERS = LifelongParameters(pass_distance=4.0)
CHAIR, TABLE = (2.2, -0.2), (-2.6, -0.2)


def box(x: float, y: float) -> NDArray[np.float64]:
    return segments([(x, y), (x + 0.4, y), (x + 0.4, y + 0.4), (x, y + 0.4)])


def with_boxes(*places: tuple[float, float]) -> NDArray[np.float64]:
    return np.concatenate((ROOM, *(box(*place) for place in places)))


def go_round(frames: KeyFrames, graph: PoseGraph, walls: NDArray[np.float64], count: int = LAP) -> None:
    """Append the key frames of a lap, with a closure to the lap before at every third one."""
    for _ in range(count):
        k = int(frames.scans[-1]) + 1 if len(frames) else 0
        angle = 2.0 * np.pi * k / LAP
        pose = Pose2D(np.cos(angle), np.sin(angle), (angle + np.pi / 2.0 + np.pi) % (2.0 * np.pi) - np.pi)
        frames.add(scan_at(pose, LASER, walls, noise=0.01, seed=k), k, pose, np.array((1e4, 0, 0, 1e4, 0, 1e5)))
        append_key_frame(graph, frames)
        before = np.flatnonzero(frames.scans == k - LAP)
        if k % 3 == 0 and len(before):
            first, second = int(before[0]), len(frames) - 1
            graph.add_edge(first, second, relative(*frames.poses[[first, second]]), 1e3 * np.eye(3), EdgeKind.CLOSURE)


def mapped(*laps: NDArray[np.float64], after: tuple[KeyFrames, PoseGraph] | None = None) -> tuple[KeyFrames, PoseGraph]:
    """Return the key frames of laps, after others, thinned after each lap."""
    frames, graph = KeyFrames(LASER), PoseGraph()
    if after is not None:
        of, graph = after[0], after[1].copy()
        frames.extend(of.poses, of.information, of.scans, ScanPoints(of.points, of.normals, of.valid))
    for walls in laps:
        since = len(frames)
        go_round(frames, graph, walls)
        thinned = thin(frames, graph, Chosen(since, np.zeros(len(frames), np.bool_)), PARAMETERS)
        assert thinned is not None
        frames, graph = thinned.frames, thinned.graph
    return frames, graph
