"""Redundancy: key frames that show nothing that others do not show.

Of the key frames that show one place, the oldest stay, so that the map does not drift, and the ones of the last two
passes, by which changes are found. So their number is bounded by the area of the map and not by the time.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.lifelong.neighbourhood import Neighbourhood
from ppaas.mapping.lifelong.scan_views import View
from ppaas.planar_poses import PoseArray

SAME_PLACE = 1.0
"""Largest distance of key frames that stand for each other [m], see `apart`."""

PASSES = 2
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
        passes, confirmed = near.passes[rows], near.views.seen[rows] == View.CONFIRMED
        newer = np.unique(passes[passes > near.own])
        if len(newer) < PASSES:
            return
        shown = sum((confirmed[passes == number].any(axis=0) for number in newer), np.zeros(valid.shape[1], np.int64))
        own = valid[near.frame]
        if passes[0] < near.own:
            older = confirmed[passes < near.own].any(axis=0)
            redundant = self._hold(older & (shown >= PASSES), own)
        else:
            usual = np.median(valid[near.others[rows]].sum(axis=1))
            redundant = own.sum() < MOSTLY_OUTDATED * usual and self._hold(shown >= PASSES, own)
        self.removed[near.frame] = redundant

    def _hold(self, held: NDArray[np.bool_], own: NDArray[np.bool_]) -> bool:
        """Return whether enough of the readings (b,) of a key frame are held by others."""
        return bool((held & own).sum() >= self._share * own.sum())


def apart(pose: PoseArray, others: PoseArray) -> NDArray[np.float64]:
    """Return the distances (m,) of poses (m, 3) from one, in which 1 rad counts as about 1 m, as in `nearest_poses`."""
    turn = 2.0 * np.sin(0.5 * (others[:, 2] - pose[2]))
    distances: NDArray[np.float64] = np.hypot(np.hypot(others[:, 0] - pose[0], others[:, 1] - pose[1]), turn)
    return distances
