"""Joint maps of two simulated robots, put together by their true poses and not by a search."""

import numpy as np

from benchmarks.mapping.simulated_drive import SimulatedDrive
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.merging.common_laser import joined_frames
from ppaas.mapping.merging.hypothesis import joined_graph
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import compose, relative


def start_of(drive: SimulatedDrive) -> Pose2D:
    """Return the map frame of a drive in the world: that in which its first pose is that of its odometry."""
    odometry, true = (Pose2D(*poses[0].tolist()) for poses in (drive.log.odometry, drive.true))
    return true @ odometry.inverse()


def motion_between(first: SimulatedDrive, second: SimulatedDrive) -> Pose2D:
    """Return the map frame of the second drive in that of the first."""
    return start_of(first).inverse() @ start_of(second)


def joint_map(first: tuple[SimulatedDrive, Mapping], second: tuple[SimulatedDrive, Mapping]) -> Mapping:
    """Return one mapping of the live mappings of two drives."""
    (drive, mapping), (other_drive, other) = first, second
    count, motion = len(mapping.frames), np.array(motion_between(drive, other_drive))
    frames, graph = joined_frames(mapping.frames, other.frames), joined_graph(mapping.graph, other.graph)
    frames.poses[:count] = mapping.graph.poses
    frames.poses[count:] = compose(motion, other.graph.poses)
    graph.move_nodes(frames.poses)
    graph.add_edge(0, count, relative(*frames.poses[[0, count]]), 1e4 * np.eye(3), EdgeKind.CLOSURE)
    return Mapping(frames, graph, mapping.laser_frame)
