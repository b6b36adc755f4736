"""Alignment of a scan with key frames: Gauss-Newton over distances from points to lines."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.kernels import alignment as kernels
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.scan_points import ScanPoints


class AlignmentSettings(NamedTuple):
    """Settings of an alignment.

    Parameters
    ----------
    gates : tuple of float
        Largest distance of a pair in each iteration, descending [m].
    scale : float
        Distance at which the weight of a pair is a quarter (Geman-McClure) [m]; it grows with gates above 0.15 m.
    deviation : float
        Standard deviation of one distance, of which the information is calculated [m].
    beams : int
        Largest number of beams to each side of a point's bearing among which its pair is searched.
    """

    gates: tuple[float, ...] = (0.5, 0.3, 0.2, 0.15, 0.15, 0.15, 0.15)
    scale: float = 0.03
    deviation: float = 0.02
    beams: int = 8


CHECKING = AlignmentSettings()
"""Settings to check a loop closure."""

TRACKING = AlignmentSettings(deviation=0.05)
"""Settings to track a scan. Several key frames repeat one error, so each pair counts less."""

NO_PRIOR = (100.0, 100.0, 100.0)
"""Standard deviations that stand for no prior [m, m, rad]."""


class Prior(NamedTuple):
    """Gaussian that an aligned pose is drawn to.

    Parameters
    ----------
    pose : Pose2D
        Mean, in the map frame.
    deviations : tuple of float
        Standard deviations along x, y [m] and theta [rad] of the mean's own frame; above 0.
    """

    pose: Pose2D
    deviations: tuple[float, float, float]


class Aligned(NamedTuple):
    """Result of an alignment.

    Parameters
    ----------
    pose : Pose2D
        Pose of the laser in the map frame.
    information : (6,) float64 array
        Information xx, xy, xt, yy, yt, tt of the pose in the frame of the scan, including the prior's.
    ratio : float
        Part of the scan's points that have a pair in the key frame in which most have one, from 0 to 1.
    pairs : int
        Number of pairs in all key frames.
    """

    pose: Pose2D
    information: NDArray[np.float64]
    ratio: float
    pairs: int


def align(
    scan: ScanPoints,
    start: Pose2D,
    key_frames: KeyFrames,
    near: NearFrames,
    settings: AlignmentSettings = CHECKING,
    *,
    prior: Prior | None = None,
) -> Aligned:
    """Return the pose at which a scan fits key frames best, near a start.

    Each point is paired with the nearest point that has a normal, among the beams of a key frame around the point's
    bearing (projective association); the distance to its line is minimized over all pairs.

    Parameters
    ----------
    scan : ScanPoints
        Scan to align.
    start : Pose2D
        Pose of the laser in the map frame from which the iterations start.
    key_frames : KeyFrames
        Scans of the map, of the same laser.
    near : NearFrames
        Key frames to align with, and their poses, which stay fixed.
    settings : AlignmentSettings
        Gates and weights.
    prior : Prior, optional
        Expected pose. Without it, a pose that the pairs do not determine stays where it started.
    """
    geometry, expected = key_frames.geometry, prior.pose if prior else start
    deviations = np.array(prior.deviations if prior else NO_PRIOR)
    pose, information, ratio, pairs = kernels.align(
        *scan,
        np.array(start),
        near.indices,
        near.poses,
        key_frames.points,
        key_frames.normals,
        geometry.angle_min,
        geometry.beams_per_radian,
        geometry.beams_per_turn,
        np.array(settings.gates),
        settings.scale,
        settings.beams,
        settings.deviation,
        np.array(expected),
        1.0 / np.square(deviations),
    )
    return Aligned(Pose2D(*pose.tolist()), information, ratio, pairs)
