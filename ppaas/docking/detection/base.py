"""Interface of detectors: what one receives, and what it returns."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.transforms.spatial import Rigid

SEARCH = 0.6
"""Distance from where the face is expected up to which it is looked for [m]."""

NO_POINTS: NDArray[np.float64] = np.empty((0, 2))


@dataclass(frozen=True, slots=True)
class DockView:
    """What a robot senses at one time, in its own frame.

    Parameters
    ----------
    points : (n, 2) array
        Readings of a scan, in the order of their beams [m].
    intensities : (n,) array, optional
        Their intensities; None if the laser measures none.
    detected : Rigid, optional
        Pose that another detector, such as one of AprilTags in camera images, gives.
    mapped : Pose2D, optional
        Face of the dock by the map and the robot's localization; None as long as the robot is not localized.
    """

    points: NDArray[np.float64]
    intensities: NDArray[np.float64] | None = None
    detected: Rigid | None = None
    mapped: Pose2D | None = None


class DockDetector(ABC):
    """Finds the face of a dock: the frame in the middle of it, whose x points into the dock."""

    name: ClassVar[str]
    purpose: ClassVar[str]
    """What it looks for, in words."""

    @property
    def protrusion(self) -> float:
        """How far parts of the dock stand before its face [m]."""
        return 0.0

    @abstractmethod
    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the face in the robot's frame, None if it is not seen.

        Parameters
        ----------
        view : DockView
        expected : Pose2D
            Where the face is expected, in the robot's frame.
        """
