"""Poses of key frames by their times, as a 2D map corrects them."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D

JUMP, JUMP_TURN = 0.5, 0.3
"""Motion of a key frame above which all that is known in the map frame has to move with it [m, rad]."""


class Anchor(NamedTuple):
    """Key frame that a point cloud hangs on.

    Parameters
    ----------
    stamp : float
        Time of the key frame [s].
    pose : Pose2D
        Pose of the robot in the map frame at that time.
    """

    stamp: float
    pose: Pose2D


@dataclass(frozen=True, slots=True, eq=False)
class KeyFramePoses:
    """Poses of the robot in the map frame at its key frames.

    Parameters
    ----------
    stamps : (k,) float64 array
        Times of the key frames, ascending [s].
    poses : (k, 3) float64 array
        x, y [m], theta [rad].
    """

    stamps: NDArray[np.float64]
    poses: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.stamps)

    def anchor(self, stamp: float) -> Anchor:
        """Return the last key frame up to a time, or the first if all are later; there must be one."""
        index = max(int(np.searchsorted(self.stamps, stamp, side="right")) - 1, 0)
        return Anchor(float(self.stamps[index]), Pose2D(*self.poses[index].tolist()))

    def motion_since(self, before: "KeyFramePoses", stamp: float) -> Pose2D:
        """Return the motion in the map frame of the key frame at a time.

        If that key frame was removed meanwhile, it is the motion of the one nearest in time that was not.
        """
        common, first, second = np.intersect1d(before.stamps, self.stamps, assume_unique=True, return_indices=True)
        if not len(common):
            return Pose2D(0.0, 0.0, 0.0)
        nearest = int(np.abs(common - stamp).argmin())
        old, new = (Pose2D(*poses.tolist()) for poses in (before.poses[first[nearest]], self.poses[second[nearest]]))
        return new @ old.inverse()

    def carry(self, pose: Pose2D, before: "KeyFramePoses") -> Pose2D:
        """Return a pose of the map frame that moves with the key frame that was nearest to it; there must be one."""
        nearest = int(np.argmin(np.hypot(*(before.poses[:, :2] - pose[:2]).T)))
        return self.motion_since(before, float(before.stamps[nearest])) @ pose

    def jump_since(self, before: "KeyFramePoses") -> Pose2D | None:
        """Return the motion of the last key frame before, if the map is in another frame now; else None.

        Loop closures move it less than `JUMP`, mostly; a map that was joined with others is in their frame.
        """
        if not len(before) or not len(self):
            return None
        at = float(before.stamps[-1])
        motion, pose = self.motion_since(before, at), before.anchor(at).pose
        is_jump = pose.distance_to(motion @ pose) > JUMP or abs(motion.theta) > JUMP_TURN
        return motion if is_jump else None

    def differs(self, before: "KeyFramePoses") -> bool:
        """Return whether a key frame has moved since, or none of those before is left."""
        common, first, second = np.intersect1d(before.stamps, self.stamps, assume_unique=True, return_indices=True)
        return not len(common) or not np.array_equal(before.poses[first], self.poses[second])


NO_KEY_FRAMES = KeyFramePoses(np.empty(0), np.empty((0, 3)))
