"""Text logs: logs of CARMEN, and pose graphs with scans.

``FLASER`` and ``ROBOTLASER1`` are scans with the poses of the laser and the robot (http://carmen.sourceforge.net,
``logger_message.html``); in a corrected log, the poses are the corrected ones. ``VERTEX2`` is a corrected pose.
``EDGE2`` is the relative pose of two vertices; edges between consecutive vertices are the odometry. All other lines
are ignored.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BufferedReader, TextIOWrapper
from itertools import pairwise, repeat
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from robots.recordings.files import UncompressedFile
from robots.recordings.recording import Look, Recording

MOST_BYTES = 1 << 30
"""Largest size of a log, after decompression [bytes]."""
NO_READING = 80.0
"""Range of a beam without a hit, in logs without a maximum range [m]."""


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


@dataclass(slots=True)
class LogLines:
    """Content of the lines of a log, in their order.

    Parameters
    ----------
    scans : list of LogScan
    vertices : list of Pose2D
        Corrected poses of the robot.
    edges : dict of int to Pose2D
        Relative pose from a vertex to the next, by the number of the vertex.
    cut : bool
        Whether the file ends in the middle of a line or of a compressed block.
    """

    scans: list[LogScan] = field(default_factory=list)
    vertices: list[Pose2D] = field(default_factory=list)
    edges: dict[int, Pose2D] = field(default_factory=dict)
    cut: bool = False

    def odometry(self, path: Path) -> list[Pose2D]:
        """Return the pose of the robot in the odometry frame at each scan: of the edges, or of the scans themselves.

        Raises
        ------
        InvalidInput
            There are edges, but one between consecutive vertices is missing.
        """
        if not self.edges:
            return [scan.robot for scan in self.scans]
        poses = [Pose2D(0.0, 0.0)]
        for vertex in range(len(self.scans) - 1):
            if vertex not in self.edges:
                raise InvalidInput(f"{path} has no EDGE2 from {vertex} to {vertex + 1}, so its odometry is incomplete")
            poses.append(poses[-1] @ self.edges[vertex])
        return poses


def read_lines(path: Path) -> LogLines:
    """Read a log, compressed or not.

    A last line that is cut off is left out, as is the damaged end of a compressed file.

    Raises
    ------
    InvalidInput
        The file cannot be read, a line is malformed, or there is no scan.
    """
    lines = LogLines()
    for number, text in _texts(path, lines):
        words = text.split()
        if not words:
            continue
        try:
            _take(lines, words)
        except (ValueError, IndexError) as error:
            if not text.endswith("\n"):
                lines.cut = True
                break
            raise InvalidInput(f"line {number} of {path} is not a valid {words[0]}: {error}") from error
    if not lines.scans:
        raise InvalidInput(f"{path} has no scan: no line begins with FLASER or ROBOTLASER1")
    return lines


def _texts(path: Path, lines: LogLines) -> Iterator[tuple[int, str]]:
    """Yield the numbers and texts of the lines of a file; comments may be in any encoding."""
    size = 0
    with (
        UncompressedFile(path) as file,
        TextIOWrapper(BufferedReader(file), encoding="utf-8-sig", errors="replace") as texts,
    ):
        for number, line in enumerate(texts, 1):
            if "\0" in line:
                raise InvalidInput(f"cannot read {path}: it is no log of text, and no bag")
            size += len(line)
            if size > MOST_BYTES:
                raise InvalidInput(f"{path} is larger than {MOST_BYTES >> 20} MiB")
            yield number, line
        lines.cut = file.cut


def _take(lines: LogLines, words: list[str]) -> None:
    kind, values = words[0], words[1:]
    if kind == "VERTEX2":
        lines.vertices.append(_pose(values[1:4]))
    elif kind == "EDGE2" and int(values[1]) == int(values[0]) + 1:
        lines.edges[int(values[0])] = _pose(values[2:5])
    elif kind == "FLASER":
        lines.scans.append(_front_laser(values))
    elif kind == "ROBOTLASER1":
        lines.scans.append(_robot_laser(values))


def _front_laser(values: list[str]) -> LogScan:
    """Return the scan of a laser that covers 180 degrees; an even number of beams leaves out the last angle."""
    count = _count(values, 0)
    step = math.pi / (count if count % 2 == 0 else count - 1)
    pose = values[1 + count :]
    ranges = _ranges(values[1 : 1 + count])
    stamp = _number(pose[6])
    return LogScan(ranges, -math.pi / 2.0, step, NO_READING, _pose(pose[:3]), _pose(pose[3:6]), stamp)


def _robot_laser(values: list[str]) -> LogScan:
    count = _count(values, 7)
    rest = values[8 + count :]
    rest = rest[1 + int(rest[0]) :]
    begin, step, most = (_number(values[place]) for place in (1, 3, 4))
    ranges, stamp = _ranges(values[8 : 8 + count]), _number(rest[11])
    return LogScan(ranges, begin, step, most, _pose(rest[:3]), _pose(rest[3:6]), stamp)


def _count(values: list[str], at: int) -> int:
    count = int(values[at])
    if not 2 <= count <= len(values) - at - 1:
        raise ValueError(f"the line does not have {count} ranges")
    return count


def _ranges(texts: list[str]) -> NDArray[np.float32]:
    return np.array([float(text) for text in texts], np.float32)


def _pose(values: list[str]) -> Pose2D:
    x, y, theta = map(_number, values)
    return Pose2D(x, y, theta)


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not finite")
    return number


# -- recordings of text logs -------------------------------------------------------------------------------------------

LEAST_RANGE = 0.02
"""Minimum range of the laser [m]."""


def read_log(path: Path) -> Recording:
    """Read a log.

    Raises
    ------
    InvalidInput
        The file cannot be read, a line is malformed, or there is no scan.
    """
    return _recording(read_lines(path), path)


def _recording(lines: LogLines, path: Path) -> Recording:
    poses = [scan.robot for scan in lines.scans]
    true = lines.vertices or poses
    if len(true) != len(poses):
        raise InvalidInput(
            f"{path} has {len(poses)} scans and {len(true)} poses (VERTEX2); their numbers must be equal"
        )
    odom = lines.odometry(path)
    stamps = [scan.stamp for scan in lines.scans]
    if any(after <= before for before, after in pairwise(stamps)):
        stamps = [float(number) for number in range(1, len(poses) + 1)]  # the log has too few digits
    scans = [_message(scan) for scan in lines.scans]
    laser = lines.scans[0].robot.inverse() @ lines.scans[0].laser
    return Recording(tuple(map(Look, stamps, odom, scans, true, repeat(laser))))


def _message(scan: LogScan) -> LaserScan:
    # The float32 nearest to the logged decimal prints as that decimal.
    ranges: list[float | None] = [float(str(value)) for value in scan.ranges]
    last = scan.angle_min + scan.angle_increment * (len(ranges) - 1)
    return LaserScan(
        Header(), angle_min=scan.angle_min, angle_max=last, angle_increment=scan.angle_increment,
        range_min=LEAST_RANGE, range_max=scan.range_max, ranges=ranges,
    )  # fmt: skip
