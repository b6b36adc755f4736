"""Redundancy: key frames that show nothing that others do not, and outdated beams, whose things have moved since."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.neighbourhood import Neighbourhood, PointSighting
from ppaas.mapping.scan_points import ScanPoints
from ppaas.planar_poses import PoseArray

SAME_PLACE = 1.0
"""Largest distance of key frames that stand for each other [m], see `apart`."""

SHOWING_PASSES = 2
"""Number of later passes that have to show a point."""

MOSTLY_OUTDATED = 0.5
"""Part of the readings of the key frames around it below which one that is not held by older ones is left out."""


class Redundancy:
    """Choice of redundant key frames, one after the other.

    Parameters
    ----------
    poses : (k, 3) array
        Poses of the key frames.
    share : float
        Part of the points that other key frames have to show.
    """

    def __init__(self, poses: PoseArray, share: float) -> None:
        self._poses, self._share = poses, share
        self.removed = np.zeros(len(poses), np.bool_)
        """Key frames (k,) that were found redundant."""

    def judge(self, near: Neighbourhood, valid: NDArray[np.bool_]) -> None:
        """Note whether a key frame is redundant.

        Parameters
        ----------
        near : Neighbourhood
        valid : (k, b) bool array
            Readings of all key frames, without those that are outdated.
        """
        rows = ~self.removed[near.others] & (apart(self._poses[near.frame], self._poses[near.others]) <= SAME_PLACE)
        passes, confirmed = near.passes[rows], near.views.seen[rows] == PointSighting.CONFIRMED
        newer = np.unique(passes[passes > near.own])
        if len(newer) < SHOWING_PASSES:
            return
        shown = sum((confirmed[passes == number].any(axis=0) for number in newer), np.zeros(valid.shape[1], np.int64))
        own = valid[near.frame]
        if passes[0] < near.own:
            older = confirmed[passes < near.own].any(axis=0)
            redundant = self._hold(older & (shown >= SHOWING_PASSES), own)
        else:
            usual = np.median(valid[near.others[rows]].sum(axis=1))
            redundant = own.sum() < MOSTLY_OUTDATED * usual and self._hold(shown >= SHOWING_PASSES, own)
        self.removed[near.frame] = redundant

    def _hold(self, held: NDArray[np.bool_], own: NDArray[np.bool_]) -> bool:
        """Return whether enough of the readings (b,) of a key frame are held by others."""
        return bool((held & own).sum() >= self._share * own.sum())


def apart(pose: PoseArray, others: PoseArray) -> NDArray[np.float64]:
    """Return the distances (m,) of poses (m, 3) from one, in which 1 rad counts as about 1 m, as in `nearest_poses`."""
    turn = 2.0 * np.sin(0.5 * (others[:, 2] - pose[2]))
    distances: NDArray[np.float64] = np.hypot(np.hypot(others[:, 0] - pose[0], others[:, 1] - pose[1]), turn)
    return distances


# -- outdated beams, as two later passes agree -------------------------------------------------------------------------

CONTRADICTING_PASSES = 2
"""Number of later passes that have to contradict a beam, one after the other."""


def outdated_beams(near: Neighbourhood) -> NDArray[np.bool_]:
    """Return the beams (b,) of a key frame that the last two passes contradict, of those that saw the place.

    A pass contradicts a beam if more of its scans look through the place of the point, or see something before it, than
    see the point. What stood there in one pass only, such as a person, is not enough.
    """
    beams = near.views.seen.shape[1]
    opinions, against = np.zeros(beams, np.int64), np.zeros(beams, np.int64)
    for number in near.newer:
        verdict = _verdict(near, near.passes == number)
        counted = (verdict != 0) & (opinions < CONTRADICTING_PASSES)
        opinions[counted] += 1
        against[counted & (verdict > 0)] += 1
    outdated: NDArray[np.bool_] = against == CONTRADICTING_PASSES
    return outdated


def _verdict(near: Neighbourhood, rows: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Return 1 for beams (b,) that a pass contradicts, -1 for those that it confirms, 0 for others."""
    seen, blocked = near.views.seen[rows], near.views.blocked[rows]
    against = ((seen == PointSighting.EMPTY) | blocked).sum(axis=0)
    confirmed = ((seen == PointSighting.CONFIRMED) & ~blocked).sum(axis=0)
    verdict: NDArray[np.int8] = np.sign(against - confirmed).astype(np.int8)
    return verdict


def without_beams(frames: KeyFrames, outdated: NDArray[np.bool_]) -> ScanPoints:
    """Return the scans (k, b) of key frames, in which some beams (k, b) have no reading."""
    if not outdated.any():
        return frames.scan_points(slice(None))
    # Lines were fitted to neighbouring points, too: normals beside a beam lean on its point.
    beside = outdated.copy()
    beside[:, :-1] |= outdated[:, 1:]
    beside[:, 1:] |= outdated[:, :-1]
    points, normals = frames.points.copy(), frames.normals.copy()
    points[outdated] = 0.0
    normals[beside] = 0.0
    return ScanPoints(points, normals, frames.valid & ~outdated)
