"""Recordings of text logs: logs of CARMEN, and pose graphs with scans."""

from itertools import pairwise, repeat
from pathlib import Path

from ppaas.errors import InvalidInput
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from robots.recordings.log_lines import LogLines, LogScan, read_lines
from robots.recordings.recording import Look, Recording

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
