"""Beginnings of mappings, as they were when a robot had driven a part of its way."""

from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.mapping import Mapping


def beginning(mapping: Mapping, count: int) -> Mapping:
    """Return the first key frames of a mapping, with the edges between them."""
    frames, edges = KeyFrames(mapping.frames.geometry), mapping.graph.edges
    part = mapping.frames
    scans = ScanPoints(part.points[:count], part.normals[:count], part.valid[:count])
    frames.extend(part.poses[:count], part.information[:count], part.scans[:count], scans)
    within = (edges.first < count) & (edges.second < count)
    return Mapping(frames, PoseGraph.of(part.poses[:count].copy(), edges.take(within)), mapping.laser_frame)
