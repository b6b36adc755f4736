"""Detectors of docks by two marks at a known distance: ``reflectors`` by their intensity, ``legs`` by their size."""

import itertools
import math
from abc import abstractmethod
from typing import ClassVar

import numpy as np

from ppaas.docking.detection.base import SEARCH, DockDetector, DockView
from ppaas.docking.detection.lines import Points, clusters, near
from ppaas.geometry import Pose2D, wrap_angle

FARTHEST_TURN = 0.8
"""Largest difference to the expected direction [rad]."""

BRIGHT = 1.5
"""Least intensity of a reflector, in multiples of the median around it, where no intensity is given."""


class PairOfMarks(DockDetector):
    """Finds two marks; the face is in the middle between them, and across the line through them.

    Parameters
    ----------
    spacing : float
        Distance between the marks [m].
    tolerance : float
        Largest difference of their measured distance [m].
    search : float
        Distance from where the face is expected up to which it is looked for [m].
    """

    def __init__(self, spacing: float, tolerance: float, search: float) -> None:
        if not (spacing > 0.0 and tolerance > 0.0 and search > 0.0):
            raise ValueError("spacing, tolerance and search must be above 0 m")
        self.spacing, self.tolerance, self.search = spacing, tolerance, search

    @abstractmethod
    def marks(self, view: DockView, expected: Pose2D) -> list[Points]:
        """Return the readings of each mark near a place."""

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the face between the two marks that fit best."""
        best, least = None, float("inf")
        centres = [mark.mean(axis=0) for mark in self.marks(view, expected)]
        for one, other in itertools.combinations(centres, 2):
            x, y = (other - one).tolist()
            wrong = abs(math.hypot(x, y) - self.spacing)
            theta = wrap_angle(math.atan2(y, x) + 0.5 * math.pi)
            if abs(wrap_angle(theta - expected.theta)) > 0.5 * math.pi:
                theta = wrap_angle(theta + math.pi)
            middle = 0.5 * (one + other)
            face = Pose2D(float(middle[0]), float(middle[1]), theta)
            misfit = wrong + expected.distance_to(face)
            turned = abs(wrap_angle(theta - expected.theta)) > FARTHEST_TURN
            far = expected.distance_to(face) > self.search
            if not (wrong > self.tolerance or turned or far or misfit >= least):
                best, least = face, misfit
        return best


class Reflectors(PairOfMarks):
    """Finds two reflectors by the intensities of the scan.

    Parameters
    ----------
    spacing, tolerance, search : float
        See `PairOfMarks`.
    intensity : float
        Least intensity of a reflector, in the unit of the laser; 0 for one far above the readings around it.
    """

    name: ClassVar[str] = "reflectors"
    purpose: ClassVar[str] = "two reflectors at a known distance, by the intensities of the scan"

    def __init__(
        self, spacing: float = 0.3, tolerance: float = 0.05, intensity: float = 0.0, search: float = SEARCH
    ) -> None:
        super().__init__(spacing, tolerance, search)
        self.intensity = intensity

    def marks(self, view: DockView, expected: Pose2D) -> list[Points]:
        """Return the bright readings, as clusters."""
        if view.intensities is None:
            return []
        around = near(view.points, expected, self.search + self.spacing)
        points, bright = view.points[around], view.intensities[around]
        if not len(points):
            return []
        usual, highest = float(np.median(bright)), float(bright.max())
        least = self.intensity or max(BRIGHT * usual, 0.5 * (usual + highest))
        return clusters(points[bright >= least], 0.4 * self.spacing)


class CartLegs(PairOfMarks):
    """Finds the two front legs of a cart or a shelf, under which a robot drives.

    Parameters
    ----------
    spacing, tolerance, search : float
        See `PairOfMarks`.
    size : float
        Largest extent of a leg [m].
    """

    name: ClassVar[str] = "legs"
    purpose: ClassVar[str] = "two legs of a cart at a known distance in the scan"

    def __init__(
        self, spacing: float = 0.5, tolerance: float = 0.05, size: float = 0.08, search: float = SEARCH
    ) -> None:
        super().__init__(spacing, tolerance, search)
        if not size > 0.0:
            raise ValueError("size must be above 0 m")
        self.size = size

    def marks(self, view: DockView, expected: Pose2D) -> list[Points]:
        """Return the clusters that are as small as legs."""
        around = view.points[near(view.points, expected, self.search + self.spacing)]
        found = clusters(around, self.size)
        return [each for each in found if float(np.ptp(each, axis=0).max()) <= self.size]
