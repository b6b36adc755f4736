"""Rebuilding: a mapping from its records, checked and bounded."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from ppaas.errors import InvalidGraph, QuotaExceeded
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph, components
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.mapping import LaserRecord, Mapping, unpack_laser
from ppaas.mapping.serialization.records import Record, RecordKind
from ppaas.mapping.serialization.rows import (
    FrameRows,
    row_range,
    unpack_edges,
    unpack_frames,
    unpack_poses,
    unpack_waiting,
)
from ppaas.planar_poses import PoseArray

MOST_BYTES = 1 << 30
"""Memory that a mapping may take by default [bytes]."""

BEAM_MEMORY, FRAME_MEMORY = 17, 400
"""Memory of a beam, and of a key frame with its edges [bytes]."""

ROW_MEMORY = {RecordKind.EDGES: 128, RecordKind.POSES: 32, RecordKind.WAITING: 2048}
"""Memory of a row of a record [bytes]."""

LAST_SCAN = 1 << 53
"""Largest index of a scan."""

FARTHEST, WIDEST = 1e7, 2.0 * np.pi
"""Largest coordinate [m] and largest angle [rad] of a pose."""

NEGATIVE = -1e-5
"""Least eigenvalue of an information matrix, as a part of its largest entry; it is rounded to float32."""


class Rebuilding:
    """Mapping that is rebuilt record by record.

    Parameters
    ----------
    most_bytes : int
        Memory that it may take [bytes].
    parts : bool
        Whether it may consist of parts that no edge connects, like the graph of a robot that was carried away.
    """

    def __init__(self, most_bytes: int = MOST_BYTES, *, parts: bool = False) -> None:
        self._most, self._parts = most_bytes, parts
        self._laser: LaserRecord | None = None
        self._rows: list[FrameRows] = []
        self._count = 0
        self._edges: list[Edges] = []
        self._waiting: list[Closure] = []
        self._memory: dict[RecordKind, int] = {}

    @property
    def count(self) -> int:
        """Number of key frames."""
        return self._count

    @property
    def laser(self) -> LaserRecord | None:
        """Laser; None before its record."""
        return self._laser

    def add(self, record: Record) -> None:
        """Add a record.

        Raises
        ------
        InvalidGraph
            It cannot be read, or does not follow the records before it.
        QuotaExceeded
            The mapping would take more memory than allowed.
        """
        kind, payload = record
        if kind == RecordKind.LASER:
            self._laser = unpack_laser(payload)
            self._laser.geometry  # noqa: B018  # raises
            self._forget()
        elif self._laser is None:
            raise InvalidGraph("the pose graph does not begin with its laser: save it again")
        elif kind == RecordKind.FRAMES:
            self._add_frames(payload, self._laser.beams)
        else:
            self._add_rows(kind, payload)

    def mapping(self) -> Mapping:
        """Return the mapping.

        Raises
        ------
        InvalidGraph
            Its parts contradict each other, or a number is out of range.
        """
        if self._laser is None or not self._rows:
            raise InvalidGraph("the pose graph has no key frame")
        rows = _joined(self._rows)
        _check_rows(rows)
        graph = PoseGraph.of(rows.poses, _all_edges(rows, self._edges))
        _check_edges(graph)
        if not self._parts and components(graph).max() > 0:
            raise InvalidGraph("the pose graph consists of parts that no edge connects: merge them first")
        _check_waiting(self._waiting, graph.node_count)
        frames = KeyFrames(self._laser.geometry)
        frames.extend(rows.poses, rows.information, rows.numbers, rows.scans)
        return Mapping(frames, graph, self._laser.frame, self._waiting)

    def _forget(self) -> None:
        self._rows, self._edges, self._waiting = [], [], []
        self._count = 0
        self._memory.clear()

    def _reserve(self, kind: RecordKind, size: int) -> None:
        """Set the memory of all rows of a kind [bytes]; raises ``QuotaExceeded`` if the mapping takes too much."""
        needed = size + sum(held for other, held in self._memory.items() if other != kind)
        if needed > self._most:
            raise QuotaExceeded(
                f"the pose graph would take {needed >> 20} MiB, and at most {self._most >> 20} are allowed: "
                "map with fewer beams, or a larger minimum_travel_distance"
            )
        self._memory[kind] = size

    def _add_rows(self, kind: RecordKind, payload: memoryview | bytes) -> None:
        """Add edges, poses or waiting closures."""
        if kind not in ROW_MEMORY:
            return
        self._reserve(kind, sum(row_range(payload)) * ROW_MEMORY[kind])
        if kind == RecordKind.EDGES:
            self._add_edges(payload)
        elif kind == RecordKind.POSES:
            self._move(unpack_poses(payload))
        else:
            self._waiting = unpack_waiting(payload)

    def _add_frames(self, payload: memoryview | bytes, beams: int) -> None:
        first, count = row_range(payload)
        if first > self._count or not count:
            raise InvalidGraph(f"the pose graph lacks key frames {self._count} to {first - 1}: save it again")
        self._reserve(RecordKind.FRAMES, (first + count) * (FRAME_MEMORY + beams * BEAM_MEMORY))
        rows = unpack_frames(payload, beams)
        if first < self._count:
            self._rows = [_until(first, _joined(self._rows))] if first else []
        self._rows.append(rows)
        self._count = first + count

    def _add_edges(self, payload: memoryview | bytes) -> None:
        first, _ = row_range(payload)
        edges = unpack_edges(payload)
        known = sum(len(part.first) for part in self._edges)
        if first > known:
            raise InvalidGraph(f"the pose graph lacks edges {known} to {first - 1}: save it again")
        if first < known:
            self._edges = [_all(self._edges).take(np.arange(first))]
        self._edges.append(edges)

    def _move(self, poses: PoseArray) -> None:
        """Move the first key frames, of those that are there."""
        for rows in self._rows:
            moved = poses[rows.first : rows.first + len(rows.poses)]
            rows.poses[: len(moved)] = moved


def _joined(rows: list[FrameRows]) -> FrameRows:
    if len(rows) == 1:
        return rows[0]
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(row, name) for row in rows]) for name in FrameRows._fields[1:-1]
    }
    scans = ScanPoints(*[np.concatenate(arrays) for arrays in zip(*(row.scans for row in rows), strict=True)])
    return FrameRows(rows[0].first, scans=scans, **columns)


def _until(end: int, rows: FrameRows) -> FrameRows:
    columns: dict[str, Any] = {name: getattr(rows, name)[:end] for name in FrameRows._fields[1:-1]}
    points, normals, valid = rows.scans
    return FrameRows(rows.first, scans=ScanPoints(points[:end], normals[:end], valid[:end]), **columns)


def _all_edges(rows: FrameRows, others: Iterable[Edges]) -> Edges:
    """Return the steps between successive key frames, then the other edges."""
    second = np.flatnonzero(rows.stepped)
    steps = Edges(
        second - 1, second, rows.steps[second], rows.step_information[second],
        np.full(len(second), EdgeKind.ODOMETRY, np.uint8),
    )  # fmt: skip
    return _all((steps, *others))


def _all(parts: Iterable[Edges]) -> Edges:
    return Edges(*map(np.concatenate, zip(*parts, strict=True)))


def _check_rows(rows: FrameRows) -> None:
    """Raise ``InvalidGraph`` unless the numbers of key frames are in range, and their scans in order."""
    poses = rows.poses
    sound = np.isfinite(poses).all() and np.isfinite(rows.information).all()
    if not sound or np.abs(poses[:, :2]).max() > FARTHEST or np.abs(poses[:, 2]).max() > WIDEST:
        raise InvalidGraph("the pose graph has a key frame whose numbers are out of range: save it again")
    numbers = rows.numbers
    if rows.stepped[0] or numbers[0] < 0 or numbers[-1] > LAST_SCAN or np.any(np.diff(numbers) <= 0):
        raise InvalidGraph("the key frames of the pose graph are not in the order of their scans: save it again")


def _check_edges(graph: PoseGraph) -> None:
    """Raise ``InvalidGraph`` unless every edge is of a known kind, and its information positive semidefinite."""
    edges = graph.edges
    if len(edges.kinds) and edges.kinds.max() > max(EdgeKind):
        raise InvalidGraph("the pose graph has an edge of an unknown kind: read it with a later release")
    least = np.linalg.eigvalsh(edges.information)[:, 0]
    wrong = np.flatnonzero(least < NEGATIVE * np.abs(edges.information).max(axis=(1, 2), initial=0.0))
    if len(wrong):
        ends = int(edges.first[wrong[0]]), int(edges.second[wrong[0]])
        raise InvalidGraph(f"the information of the edge from key frame {ends[0]} to {ends[1]} is not one: solve again")


def _check_waiting(closures: list[Closure], count: int) -> None:
    for closure in closures:
        ends = (*closure.source, *closure.target)
        nodes = np.concatenate((closure.edges.first, closure.edges.second))
        numbers = (*closure.edges.measurements.ravel(), *closure.edges.information.ravel(), *closure.motion)
        if max(ends) > count or np.any(nodes >= count) or not np.isfinite((closure.score, *numbers)).all():
            raise InvalidGraph("the pose graph has a waiting closure whose numbers are out of range: save it again")
