"""Logs of mappings: entries that are appended while a mapping grows, and that are replaced by few large ones.

The entries, in the order of their numbers, are the records of a mapping. Each key frame is an entry when it is made,
and each set of closures; the poses after a solve replace the last such entry. From time to time one entry replaces many
small ones. So the size of a log is bounded by that of its mapping.
"""

from collections.abc import Iterable
from typing import NamedTuple

from ppaas.errors import InvalidGraph
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.serialization.mapping import Mapping, pack_laser
from ppaas.mapping.serialization.rebuilding import MOST_BYTES, Rebuilding
from ppaas.mapping.serialization.records import RecordKind, pack_record, unpack_records
from ppaas.mapping.serialization.row_selection import divided_edges, frame_rows
from ppaas.mapping.serialization.rows import pack_edges, pack_frames, pack_poses, pack_waiting

FOLD = 256
"""Number of small entries that one entry replaces."""


class LogEntry(NamedTuple):
    """Entry of a log.

    Parameters
    ----------
    number : int
        Place in the order of the entries; ascending, with gaps.
    data : bytes
    """

    number: int
    data: bytes


class LogChange(NamedTuple):
    """Change of a log, to be made as a whole.

    Parameters
    ----------
    entries : list of LogEntry
        Entries to append.
    obsolete : list of int
        Numbers of entries to remove.
    """

    entries: list[LogEntry]
    obsolete: list[int]

    def then(self, later: "LogChange") -> "LogChange":
        """Return this change and a later one in one; entries that the later one removes are left out."""
        gone = set(later.obsolete)
        entries = [entry for entry in self.entries if entry.number not in gone]
        return LogChange([*entries, *later.entries], [*self.obsolete, *later.obsolete])


class GrowingMapping(NamedTuple):
    """What a log writer reads of a mapper.

    Parameters
    ----------
    frames : KeyFrames
    graph : PoseGraph
        One node per key frame; edges are only appended.
    solves : int
        Number of solves that moved key frames.
    waiting : list of Closure
    """

    frames: KeyFrames
    graph: PoseGraph
    solves: int
    waiting: list[Closure]


class LogWriter:
    """Writes the log of one mapping.

    Parameters
    ----------
    laser_frame : str
        Name of the frame of the laser.
    number : int
        Number of the first entry: above those of all earlier entries, which it makes obsolete.
    obsolete : list of int
        Numbers of earlier entries.
    """

    def __init__(self, laser_frame: str, number: int = 0, obsolete: Iterable[int] = ()) -> None:
        self._laser_frame, self._number = laser_frame, number
        self._obsolete = list(obsolete)
        self._begun = False
        self._frames = self._edges = self._others = self._solves = 0
        self._small_frames: list[int] = []
        self._small_edges: list[int] = []
        self._folded_frames = self._folded_edges = 0
        self._poses: list[int] = []
        self._waiting: list[int] = []
        self._last_waiting: list[Closure] = []

    @property
    def number(self) -> int:
        """Number of the next entry."""
        return self._number

    def write(self, growing: GrowingMapping) -> LogChange | None:
        """Return the change since the last call; None if there is none. There must be a key frame."""
        entries: list[LogEntry] = []
        if not self._begun:
            self._append(entries, pack_laser(growing.frames.geometry, self._laser_frame))
            self._begun = True
        count, solves = len(growing.frames), growing.solves
        if count > self._frames or growing.graph.edge_count > self._edges:
            self._write_rows(entries, growing)
        if solves > self._solves:
            self._replace(entries, self._poses, pack_record(RecordKind.POSES, pack_poses(growing.frames.poses)))
        if growing.waiting != self._last_waiting:
            self._last_waiting = list(growing.waiting)
            self._replace(entries, self._waiting, pack_record(RecordKind.WAITING, pack_waiting(growing.waiting)))
        self._frames, self._edges, self._solves = count, growing.graph.edge_count, solves
        obsolete, self._obsolete = self._obsolete, []
        return LogChange(entries, obsolete) if entries else None

    def _write_rows(self, entries: list[LogEntry], growing: GrowingMapping) -> None:
        frames, graph = growing.frames, growing.graph
        steps, others = divided_edges(graph)
        first = self._frames
        if len(frames) - self._folded_frames >= FOLD:
            first, self._folded_frames = self._folded_frames, len(frames)
            self._forget(self._small_frames)
        elif len(frames) > first:
            self._small_frames.append(self._number)
        if len(frames) > first:
            rows = frame_rows(frames, graph, steps, first, len(frames))
            self._append(entries, pack_record(RecordKind.FRAMES, pack_frames(rows)))
        count, known = len(others.first), self._others
        if count == known:
            return
        if len(self._small_edges) >= FOLD:
            known, self._folded_edges = self._folded_edges, count
            self._forget(self._small_edges)
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
    rebuilt = Rebuilding(most_bytes)
    for entry in entries:
        for _, record in unpack_records(entry.data):
            if record.kind == RecordKind.END:
                raise InvalidGraph("the log of the pose graph has the end of a file in it: start a new session")
            rebuilt.add(record)
    return rebuilt.mapping()
