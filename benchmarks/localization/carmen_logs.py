"""Text logs of CARMEN, and pose graphs with scans.

``FLASER`` and ``ROBOTLASER1`` are scans with the poses of the laser and the robot (http://carmen.sourceforge.net,
``logger_message.html``); in a corrected log, the poses are the corrected ones. ``VERTEX2`` is a corrected pose.
``EDGE2`` is the relative pose of two vertices; edges between consecutive vertices are the odometry.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise, repeat
from pathlib import Path

from benchmarks.localization.recording import Look, Recording
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Header

MOST_BYTES = 1 << 30
"""Largest size of a log [bytes]."""
NO_READING = 80.0
"""Range of a beam without a hit, in logs without a maximum range [m]."""
LEAST_RANGE = 0.02
"""Minimum range of the laser [m]."""


@dataclass(slots=True)
class _Lines:
    """Content of the lines of a log, in their order."""

    scans: list[tuple[LaserScan, Pose2D, Pose2D, float]] = field(default_factory=list)
    """Scan, pose of the laser, pose of the robot, stamp."""
    vertices: list[Pose2D] = field(default_factory=list)
    edges: dict[int, Pose2D] = field(default_factory=dict)
    """Relative pose from a vertex to the next, by the number of the vertex."""


def read_log(path: Path) -> Recording:
    """Read a log.

    Raises
    ------
    InvalidInput
        The file cannot be read, a line is malformed, or there is no scan.
    """
    lines = _Lines()
    for number, words in _words(path):
        try:
            _take(lines, words)
        except (ValueError, IndexError) as error:
            raise InvalidInput(f"line {number} of {path} is not a valid {words[0]}: {error}") from error
    if not lines.scans:
        raise InvalidInput(f"{path} has no scan: no line begins with FLASER or ROBOTLASER1")
    return _recording(lines, path)


def _words(path: Path) -> Iterator[tuple[int, list[str]]]:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InvalidInput(f"{path} is larger than {MOST_BYTES >> 20} MiB")
        with path.open(encoding="ascii") as file:
            for number, line in enumerate(file, 1):
                if words := line.split():
                    yield number, words
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the log: {error}") from error


def _take(lines: _Lines, words: list[str]) -> None:
    kind, values = words[0], words[1:]
    if kind == "VERTEX2":
        lines.vertices.append(_pose(values[1:4]))
    elif kind == "EDGE2" and int(values[1]) == int(values[0]) + 1:
        lines.edges[int(values[0])] = _pose(values[2:5])
    elif kind == "FLASER":
        count = _count(values, 0)
        step = math.pi / (count if count % 2 == 0 else count - 1)
        scan = _scan(values[1 : 1 + count], -math.pi / 2.0, step, NO_READING)
        pose = values[1 + count :]
        lines.scans.append((scan, _pose(pose[:3]), _pose(pose[3:6]), _number(pose[6])))
    elif kind == "ROBOTLASER1":
        count = _count(values, 7)
        scan = _scan(values[8 : 8 + count], _number(values[1]), _number(values[3]), _number(values[4]))
        rest = values[8 + count :]
        rest = rest[1 + int(rest[0]) :]
        lines.scans.append((scan, _pose(rest[:3]), _pose(rest[3:6]), _number(rest[11])))


def _count(values: list[str], at: int) -> int:
    count = int(values[at])
    if not 2 <= count <= len(values) - at - 1:
        raise ValueError(f"the line does not have {count} ranges")
    return count


def _scan(ranges: list[str], begin: float, step: float, most: float) -> LaserScan:
    read: list[float | None] = [float(value) for value in ranges]
    return LaserScan(
        Header(), angle_min=begin, angle_max=begin + step * (len(read) - 1), angle_increment=step,
        range_min=LEAST_RANGE, range_max=most, ranges=read,
    )  # fmt: skip


def _pose(values: list[str]) -> Pose2D:
    x, y, theta = map(_number, values)
    return Pose2D(x, y, theta)


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not finite")
    return number


def _recording(lines: _Lines, path: Path) -> Recording:
    poses = [robot for _, _, robot, _ in lines.scans]
    true, odom = lines.vertices or poses, poses
    if len(true) != len(poses):
        raise InvalidInput(
            f"{path} has {len(poses)} scans and {len(true)} poses (VERTEX2); their numbers must be equal"
        )
    if lines.edges:
        odom = _summed(lines.edges, len(poses), path)
    stamps = [stamp for *_, stamp in lines.scans]
    if any(after <= before for before, after in pairwise(stamps)):
        stamps = [float(number) for number in range(1, len(poses) + 1)]  # the log has too few digits
    scans = [scan for scan, *_ in lines.scans]
    laser = lines.scans[0][2].inverse() @ lines.scans[0][1]
    return Recording(tuple(map(Look, stamps, odom, scans, true, repeat(laser))))


def _summed(edges: dict[int, Pose2D], count: int, path: Path) -> list[Pose2D]:
    odom = [Pose2D(0.0, 0.0)]
    for vertex in range(count - 1):
        if vertex not in edges:
            raise InvalidInput(f"{path} has no EDGE2 from {vertex} to {vertex + 1}, so its odometry is incomplete")
        odom.append(odom[-1] @ edges[vertex])
    return odom
