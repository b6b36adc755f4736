"""Text logs: logs of CARMEN, and pose graphs with scans.

In a corrected log of CARMEN, the poses of scans are the corrected ones. ``VERTEX2`` is a corrected pose.
``EDGE2`` is the relative pose of two vertices; edges between consecutive vertices are the odometry. All other lines
are ignored.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BufferedReader, TextIOWrapper
from itertools import pairwise, repeat
from pathlib import Path

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from robots.recordings.carmen import CarmenLog, ChosenScans, LogScan, pose_of
from robots.recordings.files import UncompressedFile
from robots.recordings.recording import NO_ODOMETRY, Look, Recording

MOST_BYTES = 1 << 30
"""Largest size of a log, after decompression [bytes]."""


@dataclass(slots=True)
class LogLines:
    """Content of the lines of a log, in their order.

    Parameters
    ----------
    messages : CarmenLog
        Messages of CARMEN.
    vertices : list of Pose2D
        Corrected poses of the robot.
    edges : dict of int to Pose2D
        Relative pose from a vertex to the next, by the number of the vertex.
    cut : bool
        Whether the file ends in the middle of a line or of a compressed block.
    chosen : ChosenScans
        Scans of one laser, when all lines are read.
    """

    messages: CarmenLog = field(default_factory=CarmenLog)
    vertices: list[Pose2D] = field(default_factory=list)
    edges: dict[int, Pose2D] = field(default_factory=dict)
    cut: bool = False
    chosen: ChosenScans = field(default_factory=lambda: ChosenScans([]))

    @property
    def scans(self) -> list[LogScan]:
        """Scans of one laser."""
        return self.chosen.scans

    def notes(self, path: Path) -> list[str]:
        """Return what was left out, or is missing."""
        return [
            *([f"{path} is cut off, and was read up to the cut"] if self.cut else []),
            *self.chosen.notes,
            *([] if self.chosen.has_odometry or self.edges else [NO_ODOMETRY]),
        ]

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


def read_lines(path: Path, scan_topic: str | None = None) -> LogLines:
    """Read a log, compressed or not.

    A last line that is cut off is left out, as is the damaged end of a compressed file.

    Parameters
    ----------
    path : Path
    scan_topic : str, optional
        Name of the message whose scans are used, as ``RLASER``; by default they are of the front laser.

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
    if not lines.messages.names():
        raise InvalidInput(f"{path} has no scan: no line begins with FLASER, ROBOTLASER1 or RAWLASER1")
    try:
        lines.chosen = lines.messages.chosen(scan_topic)
    except InvalidInput as error:
        raise InvalidInput(f"cannot use the scans of {path}: {error}") from error
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
        lines.vertices.append(pose_of(values[1:4]))
    elif kind == "EDGE2" and int(values[1]) == int(values[0]) + 1:
        lines.edges[int(values[0])] = pose_of(values[2:5])
    else:
        lines.messages.take(kind, values)


# -- recordings of text logs -------------------------------------------------------------------------------------------

LEAST_RANGE = 0.02
"""Minimum range of the laser [m]."""


def read_log(path: Path, scan_topic: str | None = None) -> Recording:
    """Read a log; ``scan_topic`` is as in `read_lines`.

    Raises
    ------
    InvalidInput
        The file cannot be read, a line is malformed, or there is no scan.
    """
    return _recording(read_lines(path, scan_topic), path)


def _recording(lines: LogLines, path: Path) -> Recording:
    poses = [scan.robot for scan in lines.scans]
    stamps = [scan.stamp for scan in lines.scans]
    true = lines.vertices or _true_poses(lines, stamps)
    if len(true) != len(poses):
        raise InvalidInput(
            f"{path} has {len(poses)} scans and {len(true)} poses (VERTEX2); their numbers must be equal"
        )
    odom = lines.odometry(path)
    if any(after <= before for before, after in pairwise(stamps)):
        stamps = [float(number) for number in range(1, len(poses) + 1)]  # the log has too few digits
    scans = [_message(scan) for scan in lines.scans]
    laser = lines.scans[0].robot.inverse() @ lines.scans[0].laser
    looks = tuple(map(Look, stamps, odom, scans, true, repeat(laser)))
    return Recording(looks, tuple(lines.notes(path)), lines.chosen.has_odometry or bool(lines.edges))


def _true_poses(lines: LogLines, stamps: list[float]) -> Sequence[Pose2D | None]:
    """Return the poses of ``TRUEPOS``, or else of the scans, which are the true ones in a corrected log."""
    found = lines.messages.true_poses(stamps)
    if any(pose is not None for pose in found) or not lines.chosen.has_odometry:
        return found
    return [scan.robot for scan in lines.scans]


def _message(scan: LogScan) -> LaserScan:
    # The float32 nearest to the logged decimal prints as that decimal.
    ranges: list[float | None] = [float(str(value)) for value in scan.ranges]
    last = scan.angle_min + scan.angle_increment * (len(ranges) - 1)
    return LaserScan(
        Header(), angle_min=scan.angle_min, angle_max=last, angle_increment=scan.angle_increment,
        range_min=LEAST_RANGE, range_max=scan.range_max, ranges=ranges,
    )  # fmt: skip
