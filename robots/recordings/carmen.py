"""Messages of the logs of CARMEN: scans of lasers, odometry, true poses and parameters.

Sources: ``logger_message.html`` of http://carmen.sourceforge.net and ``writelog.c`` of its logger, which has the fields
of all messages; ``robot_frontlaser_offset`` and others as in GMapping's ``carmenconfiguration.cpp``. Each message ends
with the time of the message, the host, and the time of the logger.

Scans come with the poses of laser and robot (``ROBOTLASER1``, ``ROBOTLASER2``, and in old logs ``FLASER``, ``RLASER``),
or without them (``RAWLASER1`` to ``RAWLASER5``, ``LASER3``, ``LASER4``); those get the pose of the robot from ``ODOM``,
and the place of the laser from ``PARAM`` or ``POSITIONLASER``.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D

NO_READING = 80.0
"""Range of a beam without a hit, in logs without a maximum range [m]."""

FIELDS = {400: 100.0, 401: 100.0, 540: 270.0, 541: 270.0, 1080: 270.0, 1081: 270.0}
"""Field of view by the number of beams, of old messages without it [deg]; with other numbers it is 180°."""

OLD = {"FLASER": 1, "RLASER": 2, "LASER3": 3, "LASER4": 4}
"""Old messages, and the numbers of their lasers."""

PLACES = {1: "robot_frontlaser", 2: "robot_rearlaser"}
"""Beginning of the names of the parameters that have the place of a laser."""

RESOLUTIONS = {
    1: "laser_front_laser_resolution", 2: "laser_rear_laser_resolution",
    3: "laser_laser3_resolution", 4: "laser_laser4_resolution",
}  # fmt: skip
"""Parameters that have the angle between two beams of old messages [deg]."""

RANGES = {1: "robot_front_laser_max", 2: "robot_rear_laser_max"}
"""Parameters that have the maximum range of old messages [m]."""

WORTH_A_NOTE = 0.02
"""Share of scans before the first or after the last odometry up to which they are not worth a note."""


class LogScan(NamedTuple):
    """Scan of a log.

    Parameters
    ----------
    ranges : (b,) float32 array
        Ranges as logged [m].
    angle_min, angle_increment : float
        Angle of the first beam, and from a beam to the next [rad].
    range_max : float
        Maximum range of the laser [m].
    laser, robot : Pose2D
        Poses of the laser and the robot.
    stamp : float
        Time of the scan [s].
    """

    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_max: float
    laser: Pose2D
    robot: Pose2D
    stamp: float


class _Raw(NamedTuple):
    """Scan without poses; the fields are those of `LogScan`."""

    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_max: float
    stamp: float


class ChosenScans(NamedTuple):
    """Scans of one laser.

    Parameters
    ----------
    scans : list of LogScan
        In the order of the log; without odometry, the poses of the robot are zero.
    has_odometry : bool
        Whether the poses of the robot are known.
    notes : tuple of str
        What was left out.
    """

    scans: list[LogScan]
    has_odometry: bool = True
    notes: tuple[str, ...] = ()


class CarmenLog:
    """Messages of one log, of which some scans are chosen when all are read."""

    def __init__(self) -> None:
        self._posed: dict[str, list[LogScan]] = {}
        self._raw: dict[str, list[_Raw]] = {}
        self._odometry: list[tuple[float, ...]] = []
        self._truth: list[tuple[float, ...]] = []
        self._parameters: dict[str, str] = {}
        self._places: dict[int, Pose2D] = {}

    def take(self, kind: str, values: Sequence[str]) -> None:
        """Take a line, if it is one that has an effect.

        Raises
        ------
        ValueError, IndexError
            It is malformed.
        """
        laser = laser_of(kind)
        if kind.startswith("ROBOTLASER") and laser:
            self._posed.setdefault(kind, []).append(_robot_laser(values))
        elif kind in ("FLASER", "RLASER"):
            self._posed.setdefault(kind, []).append(self._old_laser(values, laser))
        elif kind.startswith("RAWLASER") and laser:
            self._raw.setdefault(kind, []).append(_raw_laser(values))
        elif laser:
            self._raw.setdefault(kind, []).append(self._bare_laser(values, laser))
        elif kind in ("ODOM", "TRUEPOS"):
            self._take_pose(kind, values)
        elif kind == "PARAM" and len(values) > 1:
            self._parameters[values[0]] = values[1]
        elif kind == "POSITIONLASER":
            self._places[int(values[0])] = pose_of([values[1], values[2], values[6]])

    def _take_pose(self, kind: str, values: Sequence[str]) -> None:
        """Take a pose with its time, which begins with x y theta; one that is shorter is of no use."""
        if len(values) > 6:
            into = self._odometry if kind == "ODOM" else self._truth
            into.append((number_of(values[6]), *pose_of(values[:3])))

    def _old_laser(self, values: Sequence[str], laser: int) -> LogScan:
        ranges, begin, step, most = self._beams(values, laser)
        pose = values[1 + len(ranges) :]
        return LogScan(ranges, begin, step, most, pose_of(pose[:3]), pose_of(pose[3:6]), number_of(pose[6]))

    def _bare_laser(self, values: Sequence[str], laser: int) -> _Raw:
        ranges, begin, step, most = self._beams(values, laser)
        return _Raw(ranges, begin, step, most, number_of(values[1 + len(ranges)]))

    def _beams(self, values: Sequence[str], laser: int) -> tuple[NDArray[np.float32], float, float, float]:
        """Return the ranges, the first angle, the step and the maximum range of an old message.

        An even number of beams leaves out the last angle.
        """
        count = _count(values, 0)
        gaps = count if count % 2 == 0 else count - 1
        field = math.radians(FIELDS.get(count, 180.0))
        step = math.radians(self._parameter(RESOLUTIONS.get(laser, ""), 0.0))
        if step > 0.0 and abs(step * gaps - field) > step and step * gaps < math.tau:
            field = step * gaps
        most = self._parameter(RANGES.get(laser, ""), NO_READING)
        ranges = _ranges(values[1 : 1 + count])
        return ranges, -field / 2.0, field / gaps, min(most, NO_READING) if most > 0.0 else NO_READING

    def _parameter(self, name: str, default: float) -> float:
        try:
            return number_of(self._parameters.get(name, str(default)))
        except ValueError:  # such as `none`
            return default

    # -- what is chosen ------------------------------------------------------------------------------------------------

    def names(self) -> list[str]:
        """Return the names of the messages with scans, with their numbers, in the order of lasers."""
        return [f"{name} ({count})" for name, count in sorted(self._counts().items(), key=lambda each: _rank(each[0]))]

    def chosen(self, name: str | None = None) -> ChosenScans:
        """Return the scans of one laser, as one message has them.

        By default of the first laser that has at least half as many scans as any, and of its messages with poses the
        one with most scans.

        Parameters
        ----------
        name : str, optional
            Name of the message, as ``RLASER``.

        Raises
        ------
        InvalidInput
            There is no such message; the text names those that are there.
        """
        counts = self._counts()
        used = self._usual() if name is None else name.strip("/").upper()
        if used not in counts:
            raise InvalidInput(f"there are no scans {used!r}; there are {', '.join(self.names()) or 'none'}")
        notes = [
            f"{counts[other]} scans {other} left out: they are of another laser than {used}; --scan-topic {other} uses "
            "them"
            for other in sorted(counts, key=_rank)
            if laser_of(other) != laser_of(used)
        ]
        if used in self._posed:
            return ChosenScans(self._posed[used], notes=tuple(notes))
        return self._with_poses(used, notes)

    def true_poses(self, stamps: Sequence[float]) -> list[Pose2D | None]:
        """Return the true poses of the robot (``TRUEPOS``) at some times, None where there is none."""
        return _interpolated(self._truth, stamps)

    def _counts(self) -> dict[str, int]:
        posed, raw = ({name: len(scans) for name, scans in of.items()} for of in (self._posed, self._raw))
        return posed | raw

    def _usual(self) -> str:
        counts = self._counts()
        largest = max(counts.values(), default=0)
        for laser in sorted(set(map(laser_of, counts))):
            names = [name for name in counts if laser_of(name) == laser]
            best = max(names, key=lambda name: (name in self._posed, counts[name], name))
            if 2 * counts[best] >= largest:
                return best
        return "FLASER"

    def _with_poses(self, name: str, notes: list[str]) -> ChosenScans:
        raw, place = self._raw[name], self._place(laser_of(name))
        if not self._odometry:
            zero = Pose2D(0.0, 0.0)
            still = [LogScan(*scan[:4], laser=place, robot=zero, stamp=scan.stamp) for scan in raw]
            return ChosenScans(still, False, tuple(notes))
        poses = _interpolated(self._odometry, [scan.stamp for scan in raw])
        scans = [
            LogScan(*scan[:4], laser=robot @ place, robot=robot, stamp=scan.stamp)
            for scan, robot in zip(raw, poses, strict=True)
            if robot is not None
        ]
        if not scans:
            raise InvalidInput(f"no ODOM is at the time of any of the {len(raw)} scans {name}")
        early = len(raw) - len(scans)
        if early > WORTH_A_NOTE * len(raw):
            notes.append(f"{early} of {len(raw)} scans {name} left out: there is no ODOM at their time")
        return ChosenScans(scans, True, tuple(notes))

    def _place(self, laser: int) -> Pose2D:
        """Return the pose of a laser on the robot; a rear laser looks back, unless a parameter says otherwise."""
        if laser in self._places:
            return self._places[laser]
        begin = PLACES.get(laser)
        if begin is None:
            return Pose2D(0.0, 0.0)
        x, y = (self._parameter(f"{begin}_{axis}", 0.0) for axis in ("offset", "side_offset"))
        return Pose2D(x, y, self._parameter(f"{begin}_angular_offset", math.pi if laser == 2 else 0.0))


def laser_of(kind: str) -> int:
    """Return the number of the laser whose scans a message has, 1 for the front and 2 for the rear; 0 for none."""
    number = kind[-1:]
    is_numbered = kind[:-1] in ("ROBOTLASER", "RAWLASER") and number in "12345"
    return int(number) if is_numbered and number else OLD.get(kind, 0)


def _rank(name: str) -> tuple[int, str]:
    return laser_of(name), name


def _interpolated(known: list[tuple[float, ...]], stamps: Sequence[float]) -> list[Pose2D | None]:
    """Return the poses at some times between known ones (time, x, y, theta); None before the first and after the last.

    Of several poses of one time, the first counts.
    """
    if not known:
        return [None] * len(stamps)
    table = np.array(known)
    times, first = np.unique(table[:, 0], return_index=True)
    table = table[first]
    x, y = (np.interp(stamps, times, table[:, column]) for column in (1, 2))
    theta = np.interp(stamps, times, np.unwrap(table[:, 3]))
    inside = [times[0] <= stamp <= times[-1] for stamp in stamps]
    rows = zip(inside, x.tolist(), y.tolist(), theta.tolist(), strict=True)
    return [Pose2D(*pose) if known_then else None for known_then, *pose in rows]


# -- lines -------------------------------------------------------------------------------------------------------------

_BEAMS = 7
"""Place of the number of ranges in messages that describe the laser."""

_END = ("time", "host", "time of the logger")
"""Values at the end of a message."""

_POSES = 11 + len(_END)
"""Number of values after the remissions of a message with poses."""


def _robot_laser(values: Sequence[str]) -> LogScan:
    count = _count(values, _BEAMS)
    rest = values[_BEAMS + 1 + count :]
    if not (len(rest) == _POSES and _is_name(rest[12])):  # some programs write no number of remissions
        rest = rest[1 + int(rest[0]) :]
    begin, step, most = (number_of(values[place]) for place in (1, 3, 4))
    ranges = _ranges(values[_BEAMS + 1 : _BEAMS + 1 + count])
    return LogScan(ranges, begin, step, most, pose_of(rest[:3]), pose_of(rest[3:6]), number_of(rest[11]))


def _raw_laser(values: Sequence[str]) -> _Raw:
    count = _count(values, _BEAMS)
    rest = values[_BEAMS + 1 + count :]
    if not (len(rest) == len(_END) and _is_name(rest[1])):
        rest = rest[1 + int(rest[0]) :]
    begin, step, most = (number_of(values[place]) for place in (1, 3, 4))
    return _Raw(_ranges(values[_BEAMS + 1 : _BEAMS + 1 + count]), begin, step, most, number_of(rest[0]))


def _is_name(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return True
    return False


def _count(values: Sequence[str], at: int) -> int:
    count = int(values[at])
    if not 2 <= count <= len(values) - at - 1:
        raise ValueError(f"the line does not have {count} ranges")
    return count


def _ranges(texts: Sequence[str]) -> NDArray[np.float32]:
    return np.array([float(text) for text in texts], np.float32)


def pose_of(values: Sequence[str]) -> Pose2D:
    """Return the pose of three words; raises ``ValueError`` if they are not three finite numbers."""
    x, y, theta = map(number_of, values)
    return Pose2D(x, y, theta)


def number_of(text: str) -> float:
    """Return the number of a word; raises ``ValueError`` if it is none, or not finite."""
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not finite")
    return number
