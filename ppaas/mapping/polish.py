"""Polish: the pose of every scan of a log from the refined key frames around it."""

from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import AlignmentSettings, Prior, align
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.near_poses import nearest_poses
from ppaas.mapping.scan_points import ScanPoints
from ppaas.planar_poses import PoseArray

POLISHING = AlignmentSettings(gates=(0.15, 0.1, 0.1, 0.1), deviation=0.06)
"""Settings of the alignment: the pose is nearly right, and several key frames repeat one error."""

DEVIATIONS = (0.02, 0.02, 0.01)
"""Standard deviations of the pose before [m, m, rad]."""

NEAR, RADIUS = 8, 3.0
"""Number of key frames that a scan is aligned with, and their largest distance [m]; see `nearest_poses`."""

LEAST_RATIO = 0.4
"""Least part of the points that fit; otherwise the pose stays."""


class ScanPolisher:
    """Aligns scans with the nearest key frames.

    Parameters
    ----------
    key_frames : KeyFrames
        Scans of the map.
    key_poses : (k, 3) array
        Their refined poses, which stay fixed.
    poses : (n, 3) array
        Pose of the laser in the map frame at each scan of the log.
    """

    def __init__(self, key_frames: KeyFrames, key_poses: PoseArray, poses: PoseArray) -> None:
        self._frames, self._key_poses, self._poses = key_frames, key_poses, poses
        self._near = nearest_poses(poses, key_poses, NEAR + 1, RADIUS)

    def polish(self, number: int, scan: ScanPoints) -> Pose2D:
        """Return the polished pose of a scan.

        Parameters
        ----------
        number : int
            Index of the scan. The key frame that it became, if any, is left out.
        scan : ScanPoints
            Its points.
        """
        pose = Pose2D(*self._poses[number].tolist())
        near = self._near[number]
        near = near[near >= 0]
        near = near[self._frames.scans[near] != number]
        if not len(near):
            return pose
        frames = NearFrames(near, self._key_poses[near])
        aligned = align(scan, pose, self._frames, frames, POLISHING, prior=Prior(pose, DEVIATIONS))
        return aligned.pose if aligned.ratio > LEAST_RATIO else pose
