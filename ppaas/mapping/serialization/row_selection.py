"""Row selection: the rows of key frames and edges that a mapping consists of."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.serialization.records import RecordKind, pack_record
from ppaas.mapping.serialization.rows import FrameRows, pack_edges, pack_frames

CHUNK = 256
"""Number of key frames of a record."""


def divided_edges(graph: PoseGraph) -> tuple[NDArray[np.int64], Edges]:
    """Divide the edges of a graph.

    Returns
    -------
    steps : (k,) int64 array
        Index of the first odometry edge to each node from the one before; -1 if there is none.
    others : Edges
        All other edges.
    """
    edges = graph.edges
    found = np.flatnonzero((edges.kinds == EdgeKind.ODOMETRY) & (edges.second == edges.first + 1))
    steps = np.full(graph.node_count, -1)
    steps[edges.second[found[::-1]]] = found[::-1]  # of several, the first counts
    rest = np.ones(graph.edge_count, np.bool_)
    rest[steps[steps >= 0]] = False
    return steps, edges.take(rest)


def frame_rows(frames: KeyFrames, graph: PoseGraph, steps: NDArray[np.int64], first: int, end: int) -> FrameRows:
    """Return the rows of the key frames from ``first`` to before ``end``; ``steps`` come from `divided_edges`."""
    edges, part = graph.edges, slice(first, end)
    stepped = steps[part] >= 0
    measurements, information = np.zeros((end - first, 3)), np.zeros((end - first, 3, 3))
    measurements[stepped] = edges.measurements[steps[part][stepped]]
    information[stepped] = edges.information[steps[part][stepped]]
    scans = frames.scan_points(part)
    return FrameRows(
        first, frames.poses[part], frames.information[part], frames.scans[part],
        stepped, measurements, information, scans,
    )  # fmt: skip


def packed_rows(frames: KeyFrames, graph: PoseGraph) -> Iterator[bytes]:
    """Yield the records of all key frames, then the record of all other edges if there are any."""
    steps, others = divided_edges(graph)
    for first in range(0, len(frames), CHUNK):
        rows = frame_rows(frames, graph, steps, first, min(first + CHUNK, len(frames)))
        yield pack_record(RecordKind.FRAMES, pack_frames(rows))
    if len(others.first):
        yield pack_record(RecordKind.EDGES, pack_edges(others))
