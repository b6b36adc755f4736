"""Visible points: what a scan and key frames confirm of each other, and what they contradict."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.kernels.visibility import agreement
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.scan_points import ScanPoints
from ppaas.planar_poses import relative

LEAST_VISIBLE = 10
"""Fewest points, seen by both lasers, that visibility is judged by."""


def confirmed_share(
    frames: KeyFrames, scan: ScanPoints, near: NearFrames, pose: Pose2D, tolerance: float, *, unseen: float = 0.0
) -> float:
    """Return the share of visible points that a scan and key frames confirm of each other.

    Parameters
    ----------
    frames : KeyFrames
    scan : ScanPoints
        Of the same laser.
    near : NearFrames
        Key frames to compare it with.
    pose : Pose2D
        Pose of the scan in the map frame.
    tolerance : float
        Difference of ranges that still agrees [m].
    unseen : float
        Returned if too few points are visible to both.

    Returns
    -------
    float
        From 0 to 1.
    """
    geometry = frames.geometry
    forth, back = relative(near.poses, np.array(pose)), relative(np.array(pose), near.poses)
    confirmed = contradicted = 0
    for index, there, here in zip(near.indices, forth, back, strict=True):
        other = frames.scan_points(index)
        for one, two, between in ((scan, other, there), (other, scan, here)):
            agreed, opposed = agreement(
                one.points, one.valid, two.points, two.valid, between, geometry.angle_min, geometry.angle_increment,
                tolerance,
            )  # fmt: skip
            confirmed, contradicted = confirmed + agreed, contradicted + opposed
    visible = confirmed + contradicted
    return float(confirmed / visible) if visible >= LEAST_VISIBLE else unseen
