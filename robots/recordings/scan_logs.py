"""Reads the scans and the odometry of a recording, of which a map is made."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.scan_log import LoggedScan, ScanLog, joined
from robots.recordings.carmen import LogScan
from robots.recordings.reader import is_bag
from robots.recordings.recording import Look, RecordedFrames
from robots.recordings.text_logs import LogLines, read_lines

LogFormat = Literal["carmen", "flirt", "bag"]
FORMATS: tuple[LogFormat, ...] = get_args(LogFormat)
"""Formats of recordings: logs of CARMEN, graphs of poses with scans (``VERTEX2``, ``EDGE2``), and bags of ROS."""


def read_scan_log(
    path: Path,
    form: LogFormat | None = None,
    frames: RecordedFrames | None = None,
    note: Callable[[str], None] | None = None,
) -> ScanLog:
    """Read a recording.

    The stamps are taken from the file, in its order, whether they ascend or not.

    Parameters
    ----------
    path : Path
        A log, compressed if it ends with ``.bz2``, or a bag.
    form : {"carmen", "flirt", "bag"}, optional
        Format; by default from the name of the file and its lines.
    frames : RecordedFrames, optional
        Topic and frames to read from a bag; the topic may name messages of a log of CARMEN.
    note : callable, optional
        Called with what was left out, or is missing.

    Raises
    ------
    InvalidInput
        The file cannot be read, or has no scans.
    """
    if form == "bag" or (form is None and is_bag(path)):
        from robots.recordings.ros_bags import read_bag  # noqa: PLC0415 - logs need fewer packages

        recording = read_bag(path, frames or RecordedFrames())
        if note is not None:
            for text in recording.notes:
                note(text)
        return _of_looks(recording.looks)
    lines = read_lines(path, None if frames is None else frames.scan_topic)
    if note is not None:
        for text in lines.notes(path):
            note(text)
    if form == "flirt" and not lines.edges:
        raise InvalidInput(f"{path} is not a pose graph: no line begins with EDGE2; give --format carmen")
    if form == "carmen":
        lines.edges.clear()
    return _of_lines(lines, path)


def _of_lines(lines: LogLines, path: Path) -> ScanLog:
    scans = [
        LoggedScan(_readings(scan.ranges, scan.range_max), scan.angle_min, scan.angle_increment) for scan in lines.scans
    ]
    return joined([scan.stamp for scan in lines.scans], lines.odometry(path), scans, _mount(lines.scans))


def _mount(scans: list[LogScan]) -> Pose2D:
    """Return the pose of the laser on the robot: the median over all scans, since logs have few digits."""
    poses = np.array([tuple(scan.robot.inverse() @ scan.laser) for scan in scans])
    x, y, theta = np.median(poses, axis=0).round(3).tolist()
    return Pose2D(x, y, theta)


def _of_looks(looks: tuple[Look, ...]) -> ScanLog:
    scans = []
    for look in looks:
        ranges = np.array([np.nan if value is None else value for value in look.scan.ranges], np.float32)
        ranges[ranges < look.scan.range_min] = np.nan
        scans.append(LoggedScan(_readings(ranges, look.scan.range_max), look.scan.angle_min, look.scan.angle_increment))
    stamps, odometry = [look.stamp for look in looks], [look.odom for look in looks]
    # In ROS, a scan is stamped when its first beam is measured.
    interval = abs(looks[0].scan.time_increment)
    return joined(stamps, odometry, scans, looks[0].laser, time_increment=interval, stamped_at=0.0)


def _readings(ranges: NDArray[np.float32], most: float) -> NDArray[np.float32]:
    """Return ranges with NaN where there is no reading."""
    return np.where((ranges > 0.0) & (ranges < most), ranges, np.float32(np.nan))
