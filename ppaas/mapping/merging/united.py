"""United mappings: the key frames and edges of two mappings that have some of them in common, without a search."""

from hashlib import blake2b
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.quantised_scans import pack_scans, unpack_scans
from ppaas.planar_poses import PoseArray, compose, relative

CHUNK = 256
"""Number of scans that are quantised at once."""

ID_BYTES = 16
"""Size of the id of a key frame [bytes]."""

NAME_BYTES = 8
"""Size of the number in the name of a map frame [bytes]."""

SAME_POSE = 1e-6
"""Step to which the pose of the first key frame is rounded in the name of the map frame [m, rad]."""


class United(NamedTuple):
    """Two mappings as one.

    Parameters
    ----------
    mapping : Mapping
        Key frames of the first mapping at their poses, then those that only the second one has. These hang on the key
        frame before them that both have.
    places : (k,) int64 array
        Index of each key frame of the second mapping in the result.
    """

    mapping: Mapping
    places: NDArray[np.int64]


def frame_ids(mapping: Mapping) -> list[bytes]:
    """Return the ids of the key frames: of the scan, as files have it, and of the step of the odometry that led there.

    A key frame keeps its id when a mapping is packed and read, merged, or solved.
    """
    steps = np.zeros((len(mapping.frames), 3))
    edges = mapping.graph.edges
    odometry = np.flatnonzero(edges.kinds == EdgeKind.ODOMETRY)[::-1]  # of several, the first counts
    steps[edges.second[odometry]] = edges.measurements[odometry]
    ids: list[bytes] = []
    for begin in range(0, len(steps), CHUNK):
        scans = _quantised(mapping.frames, slice(begin, begin + CHUNK))
        rows = zip(*scans, steps[begin : begin + CHUNK], strict=True)
        ids += [blake2b(b"".join(part.tobytes() for part in row), digest_size=ID_BYTES).digest() for row in rows]
    return ids


def frame_name(frames: KeyFrames) -> str:
    """Return a name of the map frame: of the first key frame and its pose, which never moves; there must be one."""
    scan = _quantised(frames, slice(0, 1))
    pose = np.round(frames.poses[0] / SAME_POSE).astype(np.int64)
    digest = blake2b(b"".join(part.tobytes() for part in (*scan, pose)), digest_size=NAME_BYTES)
    return f"map_{digest.hexdigest()}"


def united(first: Mapping, second: Mapping) -> United | None:
    """Return one mapping with all key frames and edges of two of the same laser; None if no key frame is in both.

    Poses are not solved. Both are left unchanged; closures that wait are left out.
    """
    places = _places(frame_ids(first), frame_ids(second))
    if not (places >= 0).any():
        return None
    new = np.flatnonzero(places < 0)
    poses = np.concatenate((first.graph.poses, _hung(first.graph.poses, second.graph.poses, places, new)))
    places[new] = len(first.frames) + np.arange(len(new))
    frames = _joined(first.frames, second.frames, new)
    graph = PoseGraph.of(poses, _all_edges(first, second, places))
    frames.poses[:] = poses
    return United(Mapping(frames, graph, first.laser_frame), places)


def _quantised(frames: KeyFrames, part: slice) -> ScanPoints:
    """Return scans as they are after they were packed and read."""
    exponents, data = pack_scans(frames.scan_points(part))
    return unpack_scans(exponents, data, frames.geometry.beams)


def _places(first: list[bytes], second: list[bytes]) -> NDArray[np.int64]:
    """Return the index (k,) of each id of the second list in the first, −1 if it is not there.

    Of equal ids, which scans without a point have, the n-th is paired with the n-th.
    """
    waiting: dict[bytes, list[int]] = {}
    for index in range(len(first) - 1, -1, -1):
        waiting.setdefault(first[index], []).append(index)
    return np.array([waiting[each].pop() if waiting.get(each) else -1 for each in second], np.int64).reshape(-1)


def _hung(first: PoseArray, second: PoseArray, places: NDArray[np.int64], new: NDArray[np.int64]) -> PoseArray:
    """Return the poses (n, 3) of new key frames of the second mapping in the frame of the first."""
    common = np.flatnonzero(places >= 0)
    before = common[np.maximum(np.searchsorted(common, new) - 1, 0)]
    hung: PoseArray = compose(first[places[before]], relative(second[before], second[new]))
    return hung


def _joined(first: KeyFrames, second: KeyFrames, new: NDArray[np.int64]) -> KeyFrames:
    """Return the key frames of the first mapping, then the new ones, whose scans are numbered on."""
    joined = KeyFrames(first.geometry, len(first) + len(new))
    joined.extend(first.poses, first.information, first.scans, first.scan_points(slice(None)))
    if len(new):
        numbers = second.scans[new] - second.scans[new[0]] + first.scans[-1] + 1
        scans = second.scan_points(new)
        joined.extend(second.poses[new], second.information[new], numbers, scans)
    return joined


def _all_edges(first: Mapping, second: Mapping, places: NDArray[np.int64]) -> Edges:
    """Return the edges of the first mapping, and those that only the second one has.

    The n-th edge of a kind between two nodes is the same in both, though a refinement may have changed its measurement.
    """
    own, edges = first.graph.edges, second.graph.edges
    moved = edges._replace(first=places[edges.first], second=places[edges.second])
    known = set(_edge_ids(own))
    fresh = [each not in known for each in _edge_ids(moved)]
    parts: tuple[Edges, ...] = own, moved.take(np.array(fresh, np.bool_))
    return Edges(*map(np.concatenate, zip(*parts, strict=True)))


def _edge_ids(edges: Edges) -> list[tuple[int, int, int, int]]:
    """Return the id of each edge: its nodes, its kind, and how many such edges are before it."""
    counts: dict[tuple[int, int, int], int] = {}
    ids = []
    for ends in zip(edges.first.tolist(), edges.second.tolist(), edges.kinds.tolist(), strict=True):
        ids.append((*ends, counts.get(ends, 0)))
        counts[ends] = counts.get(ends, 0) + 1
    return ids
