"""Logbook of ``grid_slam``: the head in each checkpoint, the log of the map, and the times of its key frames."""

import logging
from collections.abc import Sequence

import msgspec
import numpy as np

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import InvalidGraph
from ppaas.geometry import Pose2D
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.live.refining_mapper import RefiningMapper
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_log import FOLD, LogWriter
from ppaas.mapping.serialization.records import RecordKind, pack_record, unpack_records
from ppaas.mapping.serialization.rows import pack_times, unpack_times
from ppaas.nodes.key_frame_path import KeyFrameTimes

logger = logging.getLogger(__name__)


# -- times of key frames in the log of a map ---------------------------------------------------------------------------


class TimesLog:
    """Entries with the times of key frames. `FOLD` small entries are replaced by one."""

    def __init__(self) -> None:
        self._of: tuple[LogWriter | None, int] = None, 0
        self._written = 0
        self._entries: list[int] = []

    def change(self, writer: LogWriter, times: KeyFrameTimes) -> LogChange | None:
        """Return the times since the last call; all of them in another log, or if known ones have changed.

        Parameters
        ----------
        writer : LogWriter
            Of the log, in which they get numbers.
        times : KeyFrameTimes
        """
        obsolete: list[int] = []
        before, edition = self._of
        if writer is not before:  # its first change makes all entries of the last log obsolete
            self._entries, self._written = [], 0
        elif edition != times.edition or len(self._entries) >= FOLD:
            obsolete, self._entries, self._written = self._entries, [], 0
        self._of = writer, times.edition
        begin, self._written = self._written, len(times.numbers)
        if begin == self._written:
            return LogChange([], obsolete) if obsolete else None
        payload = pack_times(times.numbers[begin:], times.stamps[begin:])
        entry = writer.add(pack_record(RecordKind.TIMES, payload))
        self._entries.append(entry.number)
        return LogChange([entry], obsolete)

    def read(self, entries: Sequence[LogEntry], times: KeyFrameTimes) -> None:
        """Read the times of all entries of a log; of a damaged one, none: the map is then lost, too."""
        found: dict[int, float] = {}
        self._entries = []
        try:
            for number, data in entries:
                for _, (kind, payload) in unpack_records(data):
                    if kind == RecordKind.TIMES:
                        self._entries.append(number)
                        found |= dict(zip(*unpack_times(payload), strict=True))
        except InvalidGraph as error:
            logger.debug("the times of key frames cannot be read: %s", error)
            found = {}
        known = sorted((stamp, number) for number, stamp in found.items())
        times.use([number for _, number in known], [stamp for stamp, _ in known])

    def resume(self, writer: LogWriter, times: KeyFrameTimes) -> None:
        """Continue the log whose entries were read, by its writer."""
        self._of, self._written = (writer, times.edition), len(times.numbers)


# -- logbook of ``grid_slam`` ------------------------------------------------------------------------------------------

Triple = tuple[float, float, float]


class Located(msgspec.Struct, frozen=True, tag="located"):
    """State of localization in a map that stays as it is: the pose of the robot, x, y [m], theta [rad]."""

    robot: Triple
    paused: bool = False


class Head(msgspec.Struct, frozen=True, tag="head", omit_defaults=True):
    """State of a map that is being made, without the map.

    Parameters
    ----------
    key_frame : int
        Index of the key frame from which the pose hangs.
    offset : tuple of float
        Pose of the laser at the last scan in the frame of that key frame: x, y [m], theta [rad].
    odometry : tuple of float
        Odometry of the robot at that scan.
    searched : int
        Number of submaps whose closures were searched for.
    paused : bool
    correction : tuple of float, optional
        Pose of the odometry frame in the map frame, for the time in which the map is rebuilt: x, y [m], theta [rad].
        None in the heads of earlier releases.
    shared : bool
        Whether the map frame is one that other robots know.
    scan : int
        Index of the scan of that key frame, which it keeps when others are removed; -1 in the heads of earlier
        releases.
    without_odometry : bool
        Whether the map is made of scans alone.
    """

    key_frame: int
    offset: Triple
    odometry: Triple
    searched: int
    paused: bool = False
    correction: Triple | None = None
    shared: bool = False
    scan: int = -1
    without_odometry: bool = False


class Logbook:
    """Log of one map after the other; a map that begins makes the log of the last one obsolete.

    Attributes
    ----------
    times : KeyFrameTimes
        Times of the key frames of the map, which are part of the log.
    """

    def __init__(self) -> None:
        self.times = KeyFrameTimes()
        self._timed = TimesLog()
        self._writer: LogWriter | None = None
        self._numbers: set[int] = set()
        self._written = self._next = 0
        self._ended = False
        self._replacement: LogChange | None = None

    def head(self, mapper: LiveMapper, correction: Pose2D, *, paused: bool, shared: bool = False) -> Head:
        """Return the head of a map that has a key frame, and of the pose of the odometry frame in it."""
        index = len(mapper.key_frames) - 1
        frame = Pose2D(*mapper.key_frames.poses[index].tolist())
        offset, odometry = frame.inverse() @ mapper.pose, mapper.odometry
        placed = _triple(offset), _triple(odometry)
        scan = int(mapper.key_frames.scans[index])
        return Head(index, *placed, mapper.searched, paused, _triple(correction), shared, scan)

    def has_change(self, mapper: LiveMapper) -> bool:
        """Return whether there are key frames that are not in the log, or the map was refined since."""
        if self._replacement is not None or mapper.is_rewritten or len(mapper.key_frames) > self._written:
            return True
        if self._writer is None or not isinstance(mapper, RefiningMapper):
            return False
        return mapper.renewals > self._writer.renewals

    def begin(self, laser_frame: str) -> None:
        """Begin the log of another map."""
        self._end_writer()
        self._writer, self._ended = LogWriter(laser_frame, self._next, sorted(self._numbers)), False

    def end(self) -> None:
        """End the log: its entries are obsolete although no other map has begun."""
        self._end_writer()
        self._ended = True

    @property
    def has_rest(self) -> bool:
        """Whether entries of a log that has ended are stored."""
        return self._ended and bool(self._numbers)

    def rest(self) -> LogChange | None:
        """Return the removal of the entries of a log that has ended; None if there are none."""
        if not self.has_rest:
            return None
        obsolete = sorted(self._numbers)
        self._numbers.clear()
        return LogChange([], obsolete)

    def change(self, mapper: LiveMapper) -> LogChange | None:
        """Return what is new since the last call."""
        if self._writer is None:
            return None
        if mapper.is_rewritten:
            self._writer, self._replacement = self._writer.restarted(sorted(self._numbers)), None
        self._written = len(mapper.key_frames)
        change = self._writer.write(mapper.growing())
        first, self._replacement = self._replacement, None
        change = _joined(_joined(first, change), self._timed.change(self._writer, self.times))
        if change is not None:
            self._numbers |= {entry.number for entry in change.entries}
            self._numbers -= set(change.obsolete)
        return change

    def rewrite(self, mapper: LiveMapper, laser_frame: str) -> LogChange | None:
        """Return a change that replaces all entries."""
        self.begin(laser_frame)
        return self.change(mapper)

    @property
    def number(self) -> int:
        """Number of the next entry."""
        return self._next if self._writer is None else self._writer.number

    def replace(self, writer: LogWriter, change: LogChange, written: int) -> None:
        """Go on with another log of the same map, at once.

        Parameters
        ----------
        writer : LogWriter
            Of the other log.
        change : LogChange
            All its entries, with numbers above this one's.
        written : int
            Number of key frames in it.
        """
        self._replacement = LogChange(change.entries, [*change.obsolete, *sorted(self._numbers)])
        self._writer, self._written = writer, written

    def take_over(self, entries: Sequence[LogEntry]) -> None:
        """Take over the entries that are stored. Unless they are continued, the next log makes them obsolete."""
        self._writer, self._written, self._ended = None, 0, False
        self._numbers = {entry.number for entry in entries}
        self._next = max(self._numbers, default=-1) + 1
        self._timed.read(entries, self.times)

    def resume(self, writer: LogWriter, written: int) -> None:
        """Continue the log that was taken over, by its writer; it has ``written`` key frames."""
        self._writer, self._written = writer, written
        self._timed.resume(writer, self.times)

    def _end_writer(self) -> None:
        if self._writer is not None:
            self._next = self._writer.number
        self._writer, self._written, self._replacement = None, 0, None


def _joined(change: LogChange | None, later: LogChange | None) -> LogChange | None:
    return change.then(later) if change is not None and later is not None else change or later


def _triple(pose: Pose2D) -> Triple:
    return pose.x, pose.y, pose.theta


def resume(mapper: LiveMapper, mapping: Mapping, head: Head | None) -> None:
    """Continue a mapping where the head says; without one, or if the log lacks its key frame, from its last key frame.

    Parameters
    ----------
    mapper : LiveMapper
        Without a map.
    mapping : Mapping
    head : Head, optional
    """
    index = None if head is None else _key_frame(mapping, head)
    offset = Pose2D(0.0, 0.0, 0.0) if head is None or index is None else Pose2D(*head.offset)
    pose = Pose2D(*mapping.frames.poses[-1 if index is None else index].tolist()) @ offset
    odometry = Pose2D(0.0, 0.0, 0.0) if head is None else Pose2D(*head.odometry)
    mapper.resume(mapping, pose, odometry, 0 if head is None else head.searched)


def _key_frame(mapping: Mapping, head: Head) -> int | None:
    """Return the index of the key frame that a head names; None if the mapping lacks it."""
    if head.scan < 0:
        return head.key_frame if head.key_frame < len(mapping.frames) else None
    found = np.flatnonzero(mapping.frames.scans == head.scan)
    return int(found[0]) if len(found) else None
