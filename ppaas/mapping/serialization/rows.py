"""Payloads of records: key frames, edges, poses and waiting closures, as compressed arrays of little-endian numbers."""

import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.bounded import inflated
from ppaas.errors import InvalidGraph
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.quantised_scans import BEAM_BYTES, pack_scans, unpack_scans
from ppaas.mapping.serialization.records import RecordKind, pack_record
from ppaas.planar_poses import PoseArray, symmetric, upper_triangle

_COUNTS = struct.Struct("<II")
"""Index of the first row, and number of rows."""

LEVEL = 6
"""Compression level of zlib."""

_FRAME = np.dtype(
    [
        ("pose", "<f8", 3), ("information", "<f4", 6), ("scan", "<u8"),
        ("stepped", "u1"), ("step", "<f8", 3), ("step_information", "<f4", 6), ("exponent", "i1"),
    ]
)  # fmt: skip
"""Key frame without its scan; ``stepped`` is 1 if an edge leads to it from the key frame before."""

_EDGE = np.dtype(
    [("first", "<u4"), ("second", "<u4"), ("kind", "u1"), ("measurement", "<f8", 3), ("information", "<f4", 6)]
)

_WAITING = np.dtype([("submaps", "<u4", 4), ("score", "<f8"), ("motion", "<f8", 3), ("wide", "u1"), ("edges", "<u4")])
"""Closure; its edges are the next ``edges`` of the rows that follow all closures."""

_POSE = np.dtype(("<f8", 3))

_TIME = np.dtype([("scan", "<u8"), ("stamp", "<f8")])


class FrameRows(NamedTuple):
    """Successive key frames, each with the step from the one before.

    Parameters
    ----------
    first : int
        Index of the first one.
    poses : (k, 3) float64 array
    information : (k, 6) float64 array
    numbers : (k,) int64 array
        Indices of their scans.
    stepped : (k,) bool array
        Whether an edge leads to each from the one before.
    steps : (k, 3) float64 array
        Measurements of these edges.
    step_information : (k, 3, 3) float64 array
    scans : ScanPoints
        Stacked: (k, b, 2), (k, b, 2), (k, b).
    """

    first: int
    poses: PoseArray
    information: NDArray[np.float64]
    numbers: NDArray[np.int64]
    stepped: NDArray[np.bool_]
    steps: PoseArray
    step_information: NDArray[np.float64]
    scans: ScanPoints


def pack_frames(rows: FrameRows) -> bytes:
    """Return the payload of a record of key frames."""
    exponents, beams = pack_scans(rows.scans)
    table = np.zeros(len(rows.poses), _FRAME)
    table["pose"], table["information"], table["scan"] = rows.poses, rows.information, rows.numbers
    table["stepped"], table["step"] = rows.stepped, rows.steps
    table["step_information"], table["exponent"] = upper_triangle(rows.step_information), exponents
    return _COUNTS.pack(rows.first, len(table)) + zlib.compress(table.tobytes() + beams, LEVEL)


def row_range(payload: memoryview | bytes) -> tuple[int, int]:
    """Return the index of the first row of a record, and the number of its rows.

    Raises
    ------
    InvalidGraph
        The payload is too short.
    """
    if len(payload) < _COUNTS.size:
        raise _not_rows("rows")
    first, count = _COUNTS.unpack_from(payload)
    return first, count


def unpack_frames(payload: memoryview | bytes, beams: int) -> FrameRows:
    """Return the key frames of a record.

    Parameters
    ----------
    payload : memoryview or bytes
    beams : int
        Number of beams of the laser.

    Raises
    ------
    InvalidGraph
        The payload is not a record of key frames of this laser.
    """
    first, count = row_range(payload)
    of_table = count * _FRAME.itemsize
    data = _decompressed(payload[_COUNTS.size :], of_table + count * beams * BEAM_BYTES, "key frames")
    table = np.frombuffer(data, _FRAME, count)
    return FrameRows(
        first, _native(table["pose"]), _native(table["information"]), table["scan"].astype(np.int64),
        table["stepped"] != 0, _native(table["step"]), symmetric(_native(table["step_information"])),
        unpack_scans(table["exponent"], memoryview(data)[of_table:], beams),
    )  # fmt: skip


def pack_times(numbers: Sequence[int], stamps: Sequence[float]) -> bytes:
    """Return the payload of a record of the times of scans [s]."""
    table = np.zeros(len(numbers), _TIME)
    table["scan"], table["stamp"] = numbers, stamps
    return _COUNTS.pack(0, len(table)) + zlib.compress(table.tobytes(), LEVEL)


def unpack_times(payload: memoryview | bytes) -> tuple[list[int], list[float]]:
    """Return the indices of scans of a record, and their times [s]; raises ``InvalidGraph`` if it is none."""
    table = _table(payload, _TIME, "times")
    return table["scan"].tolist(), table["stamp"].tolist()


def pack_edges(edges: Edges, first: int = 0) -> bytes:
    """Return the payload of a record of edges; the first has index ``first`` among the edges of all records."""
    return _COUNTS.pack(first, len(edges.first)) + zlib.compress(_edge_table(edges).tobytes(), LEVEL)


def unpack_edges(payload: memoryview | bytes) -> Edges:
    """Return the edges of a record; raises ``InvalidGraph`` if it is none."""
    return _edges_of(_table(payload, _EDGE, "edges"))


def pack_poses(poses: PoseArray) -> bytes:
    """Return the payload of a record of poses (k, 3)."""
    return _COUNTS.pack(0, len(poses)) + zlib.compress(poses.astype("<f8").tobytes(), 1)


def unpack_poses(payload: memoryview | bytes) -> PoseArray:
    """Return the poses (k, 3) of a record; raises ``InvalidGraph`` if it is none."""
    return _native(_table(payload, _POSE, "poses"))


def pack_waiting(closures: Sequence[Closure]) -> bytes:
    """Return the payload of a record of waiting closures."""
    table = np.zeros(len(closures), _WAITING)
    for row, closure in zip(table, closures, strict=True):
        row["submaps"], row["motion"] = (*closure.source, *closure.target), closure.motion
        row["score"], row["wide"], row["edges"] = closure.score, closure.wide, len(closure.edges.first)
    edges = b"".join(_edge_table(closure.edges).tobytes() for closure in closures)
    return _COUNTS.pack(int(table["edges"].sum()), len(table)) + zlib.compress(table.tobytes() + edges, LEVEL)


def unpack_waiting(payload: memoryview | bytes) -> list[Closure]:
    """Return the waiting closures of a record; raises ``InvalidGraph`` if it is none."""
    edge_count, count = row_range(payload)
    of_table = count * _WAITING.itemsize
    data = _decompressed(payload[_COUNTS.size :], of_table + edge_count * _EDGE.itemsize, "closures")
    table, edges = np.frombuffer(data, _WAITING, count), np.frombuffer(data, _EDGE, -1, of_table)
    ends = np.cumsum(table["edges"], dtype=np.int64)
    if count and ends[-1] != edge_count:
        raise _not_rows("closures")
    parts = np.split(edges, ends[:-1])
    return [_closure_of(row, _edges_of(part)) for row, part in zip(table, parts, strict=False)]


def _closure_of(row: Any, edges: Edges) -> Closure:
    first, end, target_first, target_end = row["submaps"].tolist()
    motion = Pose2D(*row["motion"].tolist())
    return Closure(
        Submap(first, end), Submap(target_first, target_end), edges, float(row["score"]), motion, bool(row["wide"])
    )


def _edge_table(edges: Edges) -> NDArray[np.void]:
    table = np.zeros(len(edges.first), _EDGE)
    table["first"], table["second"], table["kind"] = edges.first, edges.second, edges.kinds
    table["measurement"], table["information"] = edges.measurements, upper_triangle(edges.information)
    return table


def _edges_of(table: NDArray[np.void]) -> Edges:
    return Edges(
        table["first"].astype(np.int64),
        table["second"].astype(np.int64),
        _native(table["measurement"]),
        symmetric(_native(table["information"])),
        table["kind"].astype(np.uint8),
    )


def _table(payload: memoryview | bytes, of: np.dtype[Any], what: str) -> NDArray[Any]:
    _, count = row_range(payload)
    data = _decompressed(payload[_COUNTS.size :], count * of.itemsize, what)
    return np.frombuffer(data, of.base, count * int(np.prod(of.shape, dtype=int))).reshape(count, *of.shape)


def _decompressed(payload: memoryview | bytes, size: int, what: str) -> bytes:
    """Return decompressed data of a known size; no more than that is decompressed."""
    try:
        data = inflated(payload, size)
    except (zlib.error, OverflowError) as error:
        raise _not_rows(what) from error
    if len(data) != size:
        raise _not_rows(what)
    return data


def _native(array: NDArray[Any]) -> NDArray[np.float64]:
    return np.array(array, np.float64)


def _not_rows(what: str) -> InvalidGraph:
    return InvalidGraph(f"the pose graph has a record of {what} that cannot be read: save it again")


# -- rows of which a mapping consists ----------------------------------------------------------------------------------

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
