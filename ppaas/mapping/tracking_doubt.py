"""Doubt of tracking: whether scans contradict the map, as after the robot was carried to another place."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import Aligned
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.visible_points import confirmed_share

POORLY = 0.7
"""Part of the points that fit below which a scan is compared with what the key frames show."""

USUAL, AVERAGED = 0.65, 50
"""Mean of that part, over the last scans that fit, below which scans do not contradict, and number of these scans."""

CONTRADICTED = 0.8
"""Share of the visible points that are confirmed, below which a scan contradicts the key frames."""

BETTER = 0.12
"""By how much more the scans of another place confirm each other than they are confirmed by the key frames."""

TURN_LENGTH = 0.5
"""Distance that a turn of 1 rad counts as [m/rad]."""

START = Pose2D(0.0, 0.0, 0.0)
"""Pose of the robot at the first scan that contradicts, in the frame of those that follow."""

TOLERANCE = 0.3
"""Difference of ranges that still agrees [m]."""

SCANS, TRAVEL = 5, 0.5
"""Number of successive scans that contradict, and the way driven meanwhile, after which there is a decision [m]."""


class TrackingDoubt:
    """Successive scans that contradict the key frames, and what they show.

    A single one may be of a person who stands in front of the laser. If a robot was carried away, its scans contradict
    the key frames from then on, and confirm each other. In a crowd that moves they do neither.

    Parameters
    ----------
    geometry : LaserGeometry
    """

    def __init__(self, geometry: LaserGeometry) -> None:
        self._geometry = geometry
        self._seen = KeyFrames(geometry, SCANS)
        self._scans, self._travel, self._robot = 0, 0.0, START
        self._usual, self._fitting = 0.0, 0
        self.is_lost = False

    @property
    def is_raised(self) -> bool:
        """Whether the last scan contradicted the key frames, and there is no decision yet."""
        return self._scans > 0

    def clear(self) -> None:
        """Forget the scans noted."""
        self._scans, self._travel, self._robot, self.is_lost = 0, 0.0, START, False
        self._seen = KeyFrames(self._geometry, SCANS)

    def note(self, scan: ScanPoints, step: Pose2D, ratio: float, confirmed: float) -> None:
        """Note the next scan, and decide whether the robot is lost if there are enough.

        Parameters
        ----------
        scan : ScanPoints
        step : Pose2D
            Motion of the robot by its odometry since the scan before.
        ratio : float
            Part of the points that fit the key frames.
        confirmed : float
            Share of the visible points that the key frames confirm; see `confirmation`.
        """
        if confirmed >= CONTRADICTED:
            self._fitting += 1
            self._usual += (ratio - self._usual) / min(self._fitting, AVERAGED)
            if self._scans:
                self.clear()
            return
        if self._scans:
            self._robot = self._robot @ step
            self._travel += math.hypot(step.x, step.y) + TURN_LENGTH * abs(step.theta)
        self._scans += 1
        laser = self._robot @ self._geometry.mount
        if self._scans >= SCANS and self._travel >= TRAVEL:
            by_others = confirmed_share(self._seen, scan, self._seen.latest(SCANS), laser, TOLERANCE)
            lost = by_others >= max(CONTRADICTED, confirmed + BETTER)
            self.clear()
            self.is_lost = lost
        elif self._scans <= SCANS:
            self._seen.add(scan, self._scans, laser, np.zeros(6))

    def confirmation(self, scan: ScanPoints, aligned: Aligned, frames: KeyFrames, near: NearFrames) -> float:
        """Return the share of the visible points of a scan that key frames confirm.

        It is 1 if most points of the scan fit them, or if few points of scans usually do, as outdoors: there, a scan
        that fits poorly shows nothing.

        Parameters
        ----------
        scan : ScanPoints
        aligned : Aligned
            Best alignment with the key frames.
        frames : KeyFrames
        near : NearFrames
            Those that the scan was aligned with.
        """
        if aligned.ratio >= POORLY or self._usual < USUAL:
            return 1.0
        return confirmed_share(frames, scan, near, aligned.pose, TOLERANCE, unseen=1.0)
