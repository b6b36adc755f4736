"""Check of a match, scan by scan: alignment with the older key frames, and contradictions in what both see."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.alignment import align
from ppaas.mapping.closures.kernels.visibility import agreement
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.planar_poses import relative, wrap_angles

ALIGNED_WITH = 6
"""Number of older key frames that a scan is aligned with."""

MOST_MOVED, MOST_TURNED = 0.3, 0.06
"""Largest distance and angle between a match and an aligned scan [m, rad]."""

LEAST_VISIBLE = 10
"""Fewest points, seen by both lasers, that visibility is judged by."""


class CheckedScan(NamedTuple):
    """Scan of a match that passed the check.

    Parameters
    ----------
    source, target : int
        Key frame that was aligned, and the older one nearest to it.
    measurement : (3,) array
        Pose of the source in the frame of the target: x, y [m], theta [rad].
    information : (6,) array
        Information of that pose in the frame of the source: xx, xy, xt, yy, yt, tt.
    ratio : float
        Share of the points that have a pair.
    confirmed : float
        Share of the visible points that both scans confirm.
    """

    source: int
    target: int
    measurement: NDArray[np.float64]
    information: NDArray[np.float64]
    ratio: float
    confirmed: float


class ScanCheck:
    """Check of the scans of a match.

    Parameters
    ----------
    frames : KeyFrames
    poses : (k, 3) array
        Poses of the key frames.
    parameters : ClosureParameters
    """

    def __init__(self, frames: KeyFrames, poses: NDArray[np.float64], parameters: ClosureParameters) -> None:
        self._frames, self._poses, self._parameters = frames, poses, parameters

    def run(self, source: Submap, target: Submap, moved: NDArray[np.float64]) -> list[CheckedScan]:
        """Return the scans of a match that pass.

        Parameters
        ----------
        source, target : Submap
            Key frames that were matched, and the older ones.
        moved : (m, 3) array
            Poses of the source's key frames according to the match.
        """
        n = self._parameters.checked_scans
        chosen = sorted({(2 * i + 1) * len(moved) // (2 * n) for i in range(n)})
        checked = (self._check(source.first + i, target, Pose2D(*moved[i].tolist())) for i in chosen)
        return [scan for scan in checked if scan is not None]

    def _check(self, source: int, target: Submap, start: Pose2D) -> CheckedScan | None:
        """Return one scan if it passes."""
        near = self._nearest(target, start)
        found = align(self._frames.scan_points(source), start, self._frames, near)
        if found.ratio < self._parameters.least_ratio or start.distance_to(found.pose) > MOST_MOVED:
            return None
        if abs(wrap_angle(found.pose.theta - start.theta)) > MOST_TURNED:
            return None
        if weakest_information(found.information) < self._parameters.least_information:
            return None
        confirmed = confirmed_share(self._frames, source, near, found.pose, self._parameters.visibility_tolerance)
        if confirmed < self._parameters.least_confirmed:
            return None
        measurement = relative(near.poses[0], np.array(found.pose))
        return CheckedScan(source, int(near.indices[0]), measurement, found.information, found.ratio, confirmed)

    def _nearest(self, target: Submap, pose: Pose2D) -> NearFrames:
        """Return the key frames of a submap nearest to a pose, the nearest first; a radian counts as a metre."""
        others = self._poses[target.first : target.end]
        turns = np.abs(wrap_angles(others[:, 2] - pose.theta))
        away = np.hypot(others[:, 0] - pose.x, others[:, 1] - pose.y) + turns
        indices = target.first + np.argsort(away, kind="stable")[:ALIGNED_WITH]
        return NearFrames(indices, self._poses[indices])


def weakest_information(information: NDArray[np.float64]) -> float:
    """Return the information (6,) of a position in the direction in which it is least [1/m²]."""
    xx, xy, yy = information[0], information[1], information[3]
    return float((xx + yy) / 2.0 - np.hypot((xx - yy) / 2.0, xy))


def confirmed_share(frames: KeyFrames, source: int, near: NearFrames, pose: Pose2D, tolerance: float) -> float:
    """Return the share of visible points that a scan and older key frames confirm of each other.

    Parameters
    ----------
    frames : KeyFrames
    source : int
        Key frame of the scan.
    near : NearFrames
        Older key frames.
    pose : Pose2D
        Pose of the scan in the map frame.
    tolerance : float
        Difference of ranges that still agrees [m].

    Returns
    -------
    float
        From 0 to 1; 0 if too few points are visible to both.
    """
    confirmed = contradicted = 0
    forth, back = relative(near.poses, np.array(pose)), relative(np.array(pose), near.poses)
    for other, there, here in zip(near.indices, forth, back, strict=True):
        for a, b, between in ((source, other, there), (other, source, here)):
            agreed, opposed = _agreement(frames, a, b, between, tolerance)
            confirmed, contradicted = confirmed + agreed, contradicted + opposed
    visible = confirmed + contradicted
    return confirmed / visible if visible >= LEAST_VISIBLE else 0.0


def _agreement(
    frames: KeyFrames, scan: int, other: int, pose: NDArray[np.float64], tolerance: float
) -> tuple[int, int]:
    """Return the number of points of a key frame that another confirms and contradicts, at a relative pose."""
    geometry = frames.geometry
    one, two = frames.scan_points(scan), frames.scan_points(other)
    found: tuple[int, int] = agreement(
        one.points, one.valid, two.points, two.valid, pose, geometry.angle_min, geometry.angle_increment, tolerance
    )
    return found
