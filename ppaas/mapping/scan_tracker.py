"""Scan tracker: the pose of each scan from odometry and the last key frames, and the choice of new key frames."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints


class Tracked(NamedTuple):
    """Pose of a scan.

    Parameters
    ----------
    pose : Pose2D
        Pose of the laser in the map frame.
    is_key : bool
        Whether the scan became a key frame, the last one.
    key_frame : int
        Index of the last key frame, from which the pose hangs when closures move it.
    information : (6,) float64 array
        Information of the pose in the frame of the scan, with that of the odometry; 0 of the first scan.
    ratio : float
        Part of the points that fit the key frames; 1 of the first scan.
    """

    pose: Pose2D
    is_key: bool
    key_frame: int
    information: NDArray[np.float64]
    ratio: float


class ScanTracker:
    """Tracks a laser scan by scan. The first scan is a key frame; its pose is that of the odometry.

    Parameters
    ----------
    geometry : LaserGeometry
        Laser, and its place on the robot.
    parameters : SlamParameters
        Search window, odometry noise and spacing of key frames.
    """

    def __init__(self, geometry: LaserGeometry, parameters: SlamParameters) -> None:
        self.key_frames = KeyFrames(geometry, parameters.max_key_frames)

    def add(self, scan: ScanPoints, odometry: Pose2D) -> Tracked:
        """Track the next scan.

        Parameters
        ----------
        scan : ScanPoints
            Points of the scan; see `ppaas.mapping.scan_points.prepare`.
        odometry : Pose2D
            Pose of the **robot** in the frame of the odometry at the time of the scan.

        Raises
        ------
        QuotaExceeded
            The scan is a key frame, and there are as many as allowed.
        """
        raise NotImplementedError

    def correct(self, poses: NDArray[np.float64]) -> None:
        """Move key frames, as after a closure; later key frames and the current pose move with the last one given.

        Parameters
        ----------
        poses : (m, 3) array
            Corrected poses of the first m key frames, m from 1 to the number of key frames.
        """
        raise NotImplementedError
