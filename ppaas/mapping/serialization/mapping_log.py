"""Logs of mappings: entries that are appended while a mapping grows, and that are replaced by few large ones.

The entries, in the order of their numbers, are the records of a mapping. Each key frame is an entry when it is made,
and each set of closures; the poses after a solve replace the last such entry. From time to time one entry replaces many
small ones. So the size of a log is bounded by its mapping's.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import InvalidGraph
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.serialization.mapping import Mapping, pack_laser
from ppaas.mapping.serialization.rebuilding import MOST_BYTES, Rebuilding
from ppaas.mapping.serialization.records import RecordKind, pack_record, unpack_records
from ppaas.mapping.serialization.rows import (
    divided_edges,
    frame_rows,
    pack_edges,
    pack_frames,
    pack_poses,
    pack_waiting,
    row_range,
)

FOLD = 256
"""Number of small entries that one entry replaces."""

MOST_FRAMES = 512
"""Largest number of key frames that are written at once: key frames of a loaded map come in parts."""


class Rewritten(NamedTuple):
    """Mapping of which parts were removed: its log begins again.

    Parameters
    ----------
    rows : bytes
        Records of its key frames and edges, see `packed_rows`; the poses are those after ``solves`` solves.
    frames, edges, others : int
        Numbers of the key frames, of all edges, and of those that are not steps between successive key frames.
    solves : int
    """

    rows: bytes
    frames: int
    edges: int
    others: int
    solves: int


class GrowingMapping(NamedTuple):
    """Parts of a mapper that a log writer reads.

    Parameters
    ----------
    frames : KeyFrames
    graph : PoseGraph
        One node per key frame; edges are only appended.
    solves : int
        Number of solves that moved key frames.
    waiting : list of Closure
    rewritten : Rewritten, optional
        Beginning of the mapping since which key frames and edges were only appended; for a log that begins.
    renewals : int
        Number of times that edges, other than steps between successive key frames, got other measurements.
    """

    frames: KeyFrames
    graph: PoseGraph
    solves: int
    waiting: list[Closure]
    rewritten: Rewritten | None = None
    renewals: int = 0


class LogWriter:
    """Writes the log of one mapping.

    Parameters
    ----------
    laser_frame : str
        Name of the frame of the laser.
    number : int
        Number of the first entry: above the numbers of all earlier entries, which it makes obsolete.
    obsolete : list of int
        Numbers of earlier entries.
    """

    def __init__(self, laser_frame: str, number: int = 0, obsolete: Iterable[int] = ()) -> None:
        self._laser_frame, self._number = laser_frame, number
        self._obsolete = list(obsolete)
        self._begun = False
        self._frames = self._edges = self._others = self._solves = self._renewals = 0
        self._small_frames: list[int] = []
        self._small_edges: list[int] = []
        self._large_edges: list[int] = []
        self._folded_frames = self._folded_edges = 0
        self._poses: list[int] = []
        self._waiting: list[int] = []
        self._last_waiting: list[Closure] = []

    @classmethod
    def resumed(cls, entries: Sequence[LogEntry], mapping: Mapping) -> "LogWriter":
        """Return a writer that continues a log.

        Parameters
        ----------
        entries : sequence of LogEntry
            All its entries, in the order of their numbers.
        mapping : Mapping
            The result of `read_log`.
        """
        writer = cls(mapping.laser_frame, entries[-1].number + 1)
        writer._begun, writer._last_waiting = True, list(mapping.waiting)
        writer._frames, writer._edges = len(mapping.frames), mapping.graph.edge_count
        writer._others = len(divided_edges(mapping.graph)[1].first)
        numbers = {
            RecordKind.FRAMES: writer._small_frames, RecordKind.EDGES: writer._small_edges,
            RecordKind.POSES: writer._poses, RecordKind.WAITING: writer._waiting,
        }  # fmt: skip
        for entry in entries:
            (_, record), *rows = unpack_records(entry.data)
            if rows:  # an entry with a whole mapping
                ends = {row.kind: sum(row_range(row.payload)) for _, row in rows}
                writer._folded_frames = ends[RecordKind.FRAMES]
                writer._folded_edges = ends.get(RecordKind.EDGES, 0)
            elif record.kind == RecordKind.FRAMES and (range_ := row_range(record.payload))[1] >= FOLD:
                writer._folded_frames = sum(range_)
                writer._small_frames.clear()
            elif record.kind in numbers:
                numbers[record.kind].append(entry.number)
                if record.kind == RecordKind.EDGES and not row_range(record.payload)[0]:
                    writer._folded_edges = 0  # this entry has all edges before it, too
        return writer

    def restarted(self, obsolete: Iterable[int]) -> "LogWriter":
        """Return a writer of another log of the mapping, which makes the entries of this one obsolete."""
        return LogWriter(self._laser_frame, self._number, obsolete)

    @property
    def number(self) -> int:
        """Number of the next entry."""
        return self._number

    @property
    def renewals(self) -> int:
        """Number of renewals of edges that are in the log; see `GrowingMapping`."""
        return self._renewals

    def add(self, record: bytes) -> LogEntry:
        """Return an entry with a record that is no part of the mapping, and that this writer does not replace."""
        entry = LogEntry(self._number, record)
        self._number += 1
        return entry

    def write(self, growing: GrowingMapping) -> LogChange | None:
        """Return the change since the last call; None if there is none. There must be a key frame."""
        entries: list[LogEntry] = []
        if not self._begun:
            self._begin(entries, growing)
        count, solves = min(len(growing.frames), self._frames + MOST_FRAMES), growing.solves
        is_renewed = growing.renewals > self._renewals
        if count > self._frames or growing.graph.edge_count > self._edges or is_renewed:
            self._write_rows(entries, growing, count)
        if solves > self._solves:
            self._replace(entries, self._poses, pack_record(RecordKind.POSES, pack_poses(growing.frames.poses)))
        if growing.waiting != self._last_waiting:
            self._last_waiting = list(growing.waiting)
            self._replace(entries, self._waiting, pack_record(RecordKind.WAITING, pack_waiting(growing.waiting)))
        if count == len(growing.frames):
            self._edges, self._renewals = growing.graph.edge_count, growing.renewals
        self._frames, self._solves = count, solves
        obsolete, self._obsolete = self._obsolete, []
        return LogChange(entries, obsolete) if entries else None

    def _begin(self, entries: list[LogEntry], growing: GrowingMapping) -> None:
        """Write the laser. A mapping of which parts were removed follows in the same entry: a log has all, or none."""
        self._begun, laser = True, pack_laser(growing.frames.geometry, self._laser_frame)
        rewritten = growing.rewritten
        if rewritten is None:
            self._append(entries, laser)
            return
        self._append(entries, laser + rewritten.rows)
        self._frames = self._folded_frames = rewritten.frames
        self._others = self._folded_edges = rewritten.others
        self._edges, self._solves = rewritten.edges, rewritten.solves

    def _write_rows(self, entries: list[LogEntry], growing: GrowingMapping, end: int) -> None:
        """Write the key frames before ``end``, and the other edges if these are all."""
        frames, graph = growing.frames, growing.graph
        steps, others = divided_edges(graph)
        first = self._frames
        if end - self._folded_frames >= FOLD:
            first, self._folded_frames = self._folded_frames, end
            self._forget(self._small_frames)
        elif end > first:
            self._small_frames.append(self._number)
        for begin in range(first, end, FOLD):
            rows = frame_rows(frames, graph, steps, begin, min(begin + FOLD, end))
            self._append(entries, pack_record(RecordKind.FRAMES, pack_frames(rows)))
        count, known = len(others.first), self._others
        is_renewed = growing.renewals > self._renewals
        if end < len(frames) or not (count > known or (count and is_renewed)):
            return
        if is_renewed:
            known, self._folded_edges = 0, count
            self._forget(self._small_edges)
            self._forget(self._large_edges)
            self._large_edges.append(self._number)
        elif len(self._small_edges) >= FOLD:
            known, self._folded_edges = self._folded_edges, count
            self._forget(self._small_edges)
            self._large_edges.append(self._number)
        else:
            self._small_edges.append(self._number)
        self._append(entries, pack_record(RecordKind.EDGES, pack_edges(others.since(known), known)))
        self._others = count

    def _replace(self, entries: list[LogEntry], last: list[int], data: bytes) -> None:
        self._forget(last)
        last.append(self._number)
        self._append(entries, data)

    def _append(self, entries: list[LogEntry], data: bytes) -> None:
        entries.append(LogEntry(self._number, data))
        self._number += 1

    def _forget(self, numbers: list[int]) -> None:
        self._obsolete += numbers
        numbers.clear()


def read_log(entries: Iterable[LogEntry], most_bytes: int = MOST_BYTES) -> Mapping:
    """Return the mapping of a log.

    Parameters
    ----------
    entries : iterable of LogEntry
        All entries, in the order of their numbers.
    most_bytes : int
        Memory that the mapping may take [bytes].

    Raises
    ------
    InvalidGraph
        An entry is damaged, or does not fit those before it.
    QuotaExceeded
        The mapping would take more memory than allowed.
    """
    rebuilt = Rebuilding(most_bytes, parts=True)
    for entry in entries:
        if not entry.data:
            raise InvalidGraph(f"entry {entry.number} of the log of the pose graph is empty: start a new session")
        for _, record in unpack_records(entry.data):
            if record.kind == RecordKind.END:
                raise InvalidGraph("the log of the pose graph has the end of a file in it: start a new session")
            rebuilt.add(record)
    return rebuilt.mapping()
