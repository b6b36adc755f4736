"""Frame of a map of Open-RMF against the frame of our map: turned, scaled and shifted."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle

Place = tuple[float, float]

LEAST_SPREAD = 0.1
"""Least distance of reference points from their centre [m]."""


@dataclass(frozen=True, slots=True)
class LevelFrame:
    """Similarity that leads from our frame to the frame of Open-RMF.

    Parameters
    ----------
    scale : float
        Length there of a metre here.
    rotation : float
        Angle by which our frame is turned there [rad].
    x, y : float
        Our origin there.
    residual : float
        Root mean square of the distances that are left at the reference points.
    """

    scale: float = 1.0
    rotation: float = 0.0
    x: float = 0.0
    y: float = 0.0
    residual: float = 0.0

    @classmethod
    def of(cls, rmf: Sequence[Place], robot: Sequence[Place]) -> Self:
        """Return the similarity that fits pairs of points best (least squares).

        Raises
        ------
        InvalidInput
            The points are not pairs, fewer than two, not finite, or all at one place.
        """
        if len(rmf) != len(robot) or len(rmf) < 2:
            raise InvalidInput(
                f"reference points must be pairs, two or more: {len(rmf)} are of RMF and {len(robot)} of the robot"
            )
        # As complex numbers, a rotation with a scale is one factor.
        there, here = (np.array([complex(*place) for place in places]) for places in (rmf, robot))
        if not (np.isfinite(there).all() and np.isfinite(here).all()):
            raise InvalidInput("reference points must be finite")
        far, near = there - there.mean(), here - here.mean()
        if min(np.abs(far).max(), np.abs(near).max()) < LEAST_SPREAD:
            raise InvalidInput("reference points must be apart: all of them are at one place")
        factor = complex(np.vdot(near, far) / np.vdot(near, near).real)
        shift = complex(there.mean() - factor * here.mean())
        left = float(np.sqrt(np.mean(np.abs(factor * here + shift - there) ** 2)))
        if abs(factor) < 1e-6:
            raise InvalidInput("reference points do not fit: no turned and scaled frame leads from one to the other")
        return cls(abs(factor), math.atan2(factor.imag, factor.real), shift.real, shift.imag, left)

    def to_rmf(self, pose: Pose2D) -> Pose2D:
        """Return a pose of ours in the frame of Open-RMF."""
        c, s = self.scale * math.cos(self.rotation), self.scale * math.sin(self.rotation)
        x, y = c * pose.x - s * pose.y + self.x, s * pose.x + c * pose.y + self.y
        return Pose2D(x, y, wrap_angle(pose.theta + self.rotation))

    def from_rmf(self, pose: Pose2D) -> Pose2D:
        """Return a pose of Open-RMF in our frame."""
        dx, dy = (pose.x - self.x) / self.scale, (pose.y - self.y) / self.scale
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        return Pose2D(c * dx + s * dy, c * dy - s * dx, wrap_angle(pose.theta - self.rotation))
