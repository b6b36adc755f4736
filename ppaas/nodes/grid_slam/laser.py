"""Laser of a map: the beams that all scans of the map have, and the points of a scan."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.laser_motion import laser_step, velocity
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints, prepare, with_open_beams
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.robot_scans import RobotScan

SAME_STEP = 1e-3
"""Relative difference of angle increments up to which two scans have the same beams."""

MOST_OFF = 4
"""Largest difference of the numbers of beams, and of the first beam; some drivers send a beam more or less."""


class MappingLaser:
    """Laser whose scans a map is made of.

    Parameters
    ----------
    frame : str
        Name of its frame.
    geometry : LaserGeometry
    parameters : SlamParameters

    Attributes
    ----------
    is_assumed : bool
        Whether its mount is only assumed.
    """

    def __init__(self, frame: str, geometry: LaserGeometry, parameters: SlamParameters) -> None:
        self.frame, self.geometry, self.is_assumed = frame, geometry, False
        self._parameters = parameters
        self._last: tuple[Pose2D, float] | None = None

    @classmethod
    def of(cls, scan: RobotScan, parameters: SlamParameters) -> "MappingLaser":
        """Return the laser of the first scan, which determines the beams.

        Raises
        ------
        InvalidInput
            The beams are not a laser's.
        """
        first = scan.scan
        geometry = LaserGeometry(
            first.angle_min, first.angle_increment, len(first.ranges), scan.laser, max(first.time_increment, 0.0), 0.0
        )
        return cls(scan.frame, geometry, parameters)

    def check(self, scan: RobotScan) -> None:
        """Check that a scan has the beams of this laser.

        Raises
        ------
        InvalidInput
            It is of another laser, or has other beams.
        """
        if scan.frame != self.frame:
            raise InvalidInput(f"the map is made of the scans of laser {self.frame!r}: {scan.frame!r} is not used")
        geometry, given = self.geometry, scan.scan
        step, count = geometry.angle_increment, len(given.ranges)
        off = abs(given.angle_min - geometry.angle_min) / abs(step)
        if (
            abs(given.angle_increment - step) > SAME_STEP * abs(step)
            or max(off, abs(count - geometry.beams)) > MOST_OFF
        ):
            raise InvalidInput(
                f"the scan has {count} ranges from {given.angle_min:g} in steps of {given.angle_increment:g} rad; "
                f"the map is made of scans with {geometry.beams} from {geometry.angle_min:g} in steps of {step:g}: "
                "call 'clear' to start a map with other scans"
            )

    def points(self, scan: RobotScan, odometry: Pose2D, stamp: float, *, frees: bool = False) -> ScanPoints:
        """Return the points of a scan, corrected for the motion since the last one.

        Parameters
        ----------
        scan : RobotScan
            It has passed `check`.
        odometry : Pose2D
            Pose of the robot in the odometry frame at the time of the scan.
        stamp : float
            That time [s].
        frees : bool
            Whether beams that hit nothing within the range show free space.
        """
        geometry, given = self.geometry, scan.scan
        shift = round((given.angle_min - geometry.angle_min) / geometry.angle_increment)
        ranges = np.full(geometry.beams, np.nan, np.float32)
        begin, end = max(shift, 0), min(shift + len(given.ranges), geometry.beams)
        measured = np.array(given.ranges, np.float32)[begin - shift : end - shift]
        ranges[begin:end] = _readings(measured, given)
        moved = replace(geometry, angle_min=given.angle_min - shift * geometry.angle_increment)
        speed = self._velocity(odometry, stamp)
        found = prepare(ranges, moved, self._parameters, speed)
        if not frees:
            return found
        reach = min(self._parameters.max_laser_range, given.range_max)
        hit_nothing = np.zeros(geometry.beams, np.bool_)
        hit_nothing[begin:end] = ~(measured < reach)  # NaN too: frames of JSON have null for infinity
        return with_open_beams(found, hit_nothing, reach, moved, speed)

    def move(self, mount: Pose2D) -> None:
        """Take another pose of the laser in the robot's frame, which is known now."""
        self.geometry, self.is_assumed = replace(self.geometry, mount=mount), False

    def forget_motion(self) -> None:
        """Take the laser to be at rest during the next scan, as after a reset of the odometry."""
        self._last = None

    def _velocity(self, odometry: Pose2D, stamp: float) -> NDArray[np.float64]:
        last, self._last = self._last, (odometry, stamp)
        if last is None or self.geometry.time_increment == 0.0 or stamp <= last[1]:
            return np.zeros(3)
        return velocity(laser_step(last[0], odometry, self.geometry.mount), stamp - last[1])


def _readings(measured: NDArray[np.float32], scan: LaserScan) -> NDArray[np.float32]:
    """Return some ranges (b,) of a scan; NaN where there is no reading."""
    ranges = measured.copy()
    with np.errstate(invalid="ignore"):
        ranges[~((ranges > max(scan.range_min, 0.0)) & (ranges < scan.range_max))] = np.nan
    return ranges
