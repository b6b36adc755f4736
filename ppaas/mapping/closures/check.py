"""Check of a match, scan by scan: alignment with the older key frames, and contradictions in what both see."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.alignment import align
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.key_frame_graph import forgetting, weakest_information
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.visible_points import confirmed_share
from ppaas.planar_poses import compose, relative, symmetric, upper_triangle

ALIGNED_WITH = 6
"""Number of older key frames that a scan is aligned with."""

MOST_MOVED, MOST_TURNED = 0.3, 0.06
"""Largest distance and angle between a match and an aligned scan [m, rad]."""

VIEW = 15.0
"""Points nearer than this count for the centre of what a scan shows [m]."""

SURE = 2.0
"""Factor of the least information below which a scan may slide along a corridor."""


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
        self._centres = np.full((len(frames), 2), np.nan)

    def run(
        self, source: Submap, target: Submap, moved: NDArray[np.float64], *, slides: bool = False
    ) -> list[CheckedScan]:
        """Return the scans of a match that pass.

        Parameters
        ----------
        source, target : Submap
            Key frames that were matched, and the older ones.
        moved : (m, 3) array
            Poses of the source's key frames according to the match.
        slides : bool
            Whether scans pass that leave the position along a corridor open; their information says nothing of it.
        """
        n = self._parameters.checked_scans
        chosen = sorted({(2 * i + 1) * len(moved) // (2 * n) for i in range(n)})
        checked = (self._check(source.first + i, target, Pose2D(*moved[i].tolist()), slides) for i in chosen)
        return [scan for scan in checked if scan is not None]

    def _check(self, source: int, target: Submap, start: Pose2D, slides: bool) -> CheckedScan | None:
        """Return one scan if it passes."""
        near = self._with_the_same_view(source, target, start)
        found = align(self._frames.scan_points(source), start, self._frames, near)
        if found.ratio < self._parameters.least_ratio or start.distance_to(found.pose) > MOST_MOVED:
            return None
        if abs(wrap_angle(found.pose.theta - start.theta)) > MOST_TURNED:
            return None
        information, least = found.information, self._parameters.least_information
        weakest = weakest_information(information)
        if weakest < least and not slides:
            return None
        if slides and weakest < SURE * least:
            information = _without_weakest(information)
        scan, tolerance = self._frames.scan_points(source), self._parameters.visibility_tolerance
        confirmed = confirmed_share(self._frames, scan, near, found.pose, tolerance)
        if confirmed < self._parameters.least_confirmed:
            return None
        measurement = relative(near.poses[0], np.array(found.pose))
        return CheckedScan(source, int(near.indices[0]), measurement, information, found.ratio, confirmed)

    def _with_the_same_view(self, source: int, target: Submap, pose: Pose2D) -> NearFrames:
        """Return the key frames of a submap that show most nearly what a scan shows at a pose, the nearest first.

        Two scans in opposite directions show the same part of a corridor from places far apart.
        """
        others = self._poses[target.first : target.end]
        centre = compose(np.array(pose), _as_pose(self._view_centres(source, source + 1)))[0]
        centres = compose(others, _as_pose(self._view_centres(target.first, target.end)))
        away = np.hypot(centres[:, 0] - centre[0], centres[:, 1] - centre[1])
        indices = target.first + np.argsort(away, kind="stable")[:ALIGNED_WITH]
        return NearFrames(indices, self._poses[indices])

    def _view_centres(self, first: int, end: int) -> NDArray[np.float64]:
        """Return the centres (k, 2) of what key frames show; each is calculated once."""
        missing = first + np.flatnonzero(np.isnan(self._centres[first:end, 0]))
        if missing.size:
            self._centres[missing] = _view_centres(self._frames, missing)
        return self._centres[first:end]


def _view_centres(frames: KeyFrames, chosen: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the mean (k, 2) of the points of key frames within `VIEW`, each in its own frame [m]."""
    points = frames.points[chosen].astype(np.float64)
    counted = frames.valid[chosen] & (np.hypot(points[..., 0], points[..., 1]) < VIEW)
    sums = np.einsum("kb,kbi->ki", counted.astype(np.float64), points)
    centres: NDArray[np.float64] = sums / np.maximum(counted.sum(axis=1), 1)[:, np.newaxis]
    return centres


def _as_pose(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return positions (k, 2) as poses (k, 3)."""
    return np.column_stack((positions, np.zeros(len(positions))))


def _without_weakest(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an information (6,) without the position's part in the direction in which it is least."""
    kept = forgetting(information)
    left: NDArray[np.float64] = upper_triangle(kept @ symmetric(information) @ kept)
    return left
