"""Recorded drive to make a map of: the scans of one laser with the odometry of the robot."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry

SAME_STEP = 1e-3
"""Relative difference of angle increments up to which two scans have the same beams."""


class LoggedScan(NamedTuple):
    """Scan of a log, before its beams are put in line with the other scans' beams.

    Parameters
    ----------
    ranges : (b,) float32 array
        Ranges [m]; NaN without a reading.
    angle_min, angle_increment : float
        Angle of the first beam, and from a beam to the next [rad].
    """

    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float


@dataclass(frozen=True, slots=True)
class ScanLog:
    """Scans of one laser, in the order of the log.

    Parameters
    ----------
    stamps : (n,) float64 array
        Times of the scans [s]; they need not ascend.
    odometry : (n, 3) float64 array
        Pose of the robot in the odometry frame at each scan: x, y [m], theta [rad].
    ranges : (n, b) float32 array
        Ranges [m]; NaN without a reading.
    first_angles : (n,) float64 array
        Angle of the first beam of each scan [rad]. Within half an increment of ``geometry.angle_min``: some lasers
        interleave scans.
    geometry : LaserGeometry
        Beams of the laser, and its place on the robot.
    skipped : int
        Number of scans without ranges, because their beams differ from most scans' beams.
    """

    stamps: NDArray[np.float64]
    odometry: NDArray[np.float64]
    ranges: NDArray[np.float32]
    first_angles: NDArray[np.float64]
    geometry: LaserGeometry
    skipped: int = 0

    def __len__(self) -> int:
        return len(self.stamps)

    def geometry_of(self, scan: int) -> LaserGeometry:
        """Return the beams of one scan."""
        first = float(self.first_angles[scan])
        return self.geometry if first == self.geometry.angle_min else replace(self.geometry, angle_min=first)

    def first(self, count: int) -> "ScanLog":
        """Return the log of the first scans."""
        return self.chosen(slice(count))

    def chosen(self, scans: NDArray[np.int64] | slice) -> "ScanLog":
        """Return the log of some scans, by their numbers."""
        return replace(
            self,
            stamps=self.stamps[scans],
            odometry=self.odometry[scans],
            ranges=self.ranges[scans],
            first_angles=self.first_angles[scans],
        )


def joined(
    stamps: Sequence[float],
    odometry: Sequence[Pose2D],
    scans: Sequence[LoggedScan],
    mount: Pose2D,
    *,
    time_increment: float = 0.0,
    stamped_at: float = 0.5,
) -> ScanLog:
    """Return the log of some scans, with the beams of all scans in line.

    Scans with another number of beams or a shifted first angle, as of lasers that interleave, are moved by whole beams.
    Scans with another increment get no ranges.

    Parameters
    ----------
    stamps : sequence of float
        Times of the scans [s].
    odometry : sequence of Pose2D
        Poses of the robot.
    scans : sequence of LoggedScan
        At least one.
    mount : Pose2D
        Pose of the laser on the robot.
    time_increment, stamped_at : float
        Times of the beams, as in `LaserGeometry`.

    Raises
    ------
    InvalidInput
        There is no scan, or the beams of most scans are not from one laser.
    """
    if not scans:
        raise InvalidInput("a log has no scan: a map needs at least one")
    geometry = LaserGeometry(*_most_common(scans), mount, time_increment, stamped_at)
    ranges = np.full((len(scans), geometry.beams), np.nan, np.float32)
    first_angles = np.full(len(scans), geometry.angle_min)
    fits = [_put(scan, geometry, ranges[row], first_angles[row : row + 1]) for row, scan in enumerate(scans)]
    poses = np.array([tuple(pose) for pose in odometry], np.float64)
    return ScanLog(np.array(stamps, np.float64), poses, ranges, first_angles, geometry, fits.count(False))


def _most_common(scans: Sequence[LoggedScan]) -> tuple[float, float, int]:
    """Return the first angle, the increment and the number of beams that most scans have."""
    counts: dict[tuple[float, float, int], int] = {}
    for scan in scans:
        key = (scan.angle_min, scan.angle_increment, len(scan.ranges))
        counts[key] = counts.get(key, 0) + 1
    return max(counts, key=lambda key: counts[key])


def _put(scan: LoggedScan, geometry: LaserGeometry, row: NDArray[np.float32], first_angle: NDArray[np.float64]) -> bool:
    """Write the ranges and the first angle of a scan; return whether its increment is the laser's."""
    step = geometry.angle_increment
    if abs(scan.angle_increment - step) > SAME_STEP * abs(step):
        return False
    shift = round((scan.angle_min - geometry.angle_min) / step)
    begin, end = max(shift, 0), min(shift + len(scan.ranges), geometry.beams)
    if begin >= end:
        return False
    row[begin:end] = scan.ranges[begin - shift : end - shift]
    if shift != 0 or scan.angle_min != geometry.angle_min:
        first_angle[0] = scan.angle_min - shift * step
    return True
