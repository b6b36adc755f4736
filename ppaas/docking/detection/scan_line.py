"""Detector ``scan_line``: a flat face of known width in the scan."""

from typing import ClassVar

from ppaas.docking.detection.base import SEARCH, DockDetector, DockView
from ppaas.docking.detection.lines import clusters, face_on, line_through, near, pieces
from ppaas.geometry import Pose2D, wrap_angle

LEAST = 5
"""Least number of readings on a face."""

FARTHEST_TURN = 0.8
"""Largest difference to the expected direction [rad]."""


class ScanLine(DockDetector):
    """Finds a straight line of a length; its ends show where the middle is.

    Parameters
    ----------
    width : float
        Width of the face [m].
    tolerance : float
        Largest difference of its measured width [m].
    gap : float
        Distance between two readings from which they belong to different things [m].
    flatness : float
        Largest distance of a reading from the line: three times the noise of the laser [m].
    search : float
        Distance from where the face is expected up to which it is looked for [m].
    """

    name: ClassVar[str] = "scan_line"
    purpose: ClassVar[str] = "a flat face of known width in the scan"

    def __init__(
        self, width: float = 0.4, tolerance: float = 0.1, gap: float = 0.08, flatness: float = 0.04,
        search: float = SEARCH,
    ) -> None:  # fmt: skip
        if not (width > 0.0 and tolerance > 0.0 and gap > 0.0 and flatness > 0.0 and search > 0.0):
            raise ValueError("width, tolerance, gap, flatness and search must be above 0 m")
        self.width, self.tolerance, self.gap = width, tolerance, gap
        self.flatness, self.search = flatness, search

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the face on the line that fits best."""
        best, least = None, float("inf")
        reach = self.search + self.width
        for cluster in clusters(view.points[near(view.points, expected, reach)], self.gap):
            for piece in pieces(cluster, self.flatness):
                if len(piece) < LEAST:
                    continue
                line = line_through(piece)
                face = face_on(line, expected)
                wrong = abs(line.length - self.width)
                misfit = wrong + expected.distance_to(face)
                turned = abs(wrap_angle(face.theta - expected.theta)) > FARTHEST_TURN
                far = expected.distance_to(face) > self.search
                if not (wrong > self.tolerance or turned or far or misfit >= least):
                    best, least = face, misfit
        return best
