"""Detector ``v_shape``: two flat faces that meet at an angle in the scan."""

import itertools
import math
from typing import ClassVar

from ppaas.docking.detection.base import SEARCH, DockDetector, DockView
from ppaas.docking.detection.lines import Points, clusters, line_through, near, pieces
from ppaas.geometry import Pose2D, wrap_angle

LEAST = 4
"""Least number of readings on an arm."""

FARTHEST_TURN = 0.8
"""Largest difference to the expected direction [rad]."""


class VShape(DockDetector):
    """Finds two arms that meet in an apex, where the face is; the dock is open to the robot.

    Parameters
    ----------
    angle : float
        Angle between the arms [rad].
    arm : float
        Length of an arm [m].
    tolerance : float
        Largest difference of the measured angle [rad].
    gap : float
        Distance between two readings from which they belong to different things [m].
    search : float
        Distance from where the apex is expected up to which it is looked for [m].
    """

    name: ClassVar[str] = "v_shape"
    purpose: ClassVar[str] = "two flat faces that meet at a known angle in the scan"

    def __init__(
        self, angle: float = 2.1, arm: float = 0.2, tolerance: float = 0.35, gap: float = 0.08, search: float = SEARCH
    ) -> None:
        if not (0.0 < angle < math.pi and arm > 0.0 and tolerance > 0.0 and gap > 0.0 and search > 0.0):
            raise ValueError("angle must be between 0 and π, and arm, tolerance, gap and search above 0")
        self.angle, self.arm, self.tolerance, self.gap, self.search = angle, arm, tolerance, gap, search

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the apex of the shape that fits best."""
        best, least = None, float("inf")
        around = view.points[near(view.points, expected, self.search + self.arm)]
        for cluster in clusters(around, self.gap):
            for arms in itertools.pairwise(pieces(cluster, 0.4 * self.protrusion)):
                face = self._apex_of(*arms)
                if face is None or abs(wrap_angle(face.theta - expected.theta)) > FARTHEST_TURN:
                    continue
                if expected.distance_to(face) < min(least, self.search):
                    best, least = face, expected.distance_to(face)
        return best

    @property
    def protrusion(self) -> float:
        """How far the ends of the arms stand before the apex [m]."""
        return self.arm * math.cos(0.5 * self.angle)

    def _apex_of(self, first: Points, second: Points) -> Pose2D | None:
        """Return the apex of two arms, None if they have another shape."""
        if min(len(first), len(second)) <= LEAST:
            return None
        one, other = line_through(first[:-1]), line_through(second[1:])
        if max(abs(one.length - self.arm), abs(other.length - self.arm)) > 0.4 * self.arm:
            return None
        cross = math.sin(other.direction - one.direction)
        if abs(cross) < 0.1:
            return None
        x, y = other.middle[0] - one.middle[0], other.middle[1] - one.middle[1]
        along = (x * math.sin(other.direction) - y * math.cos(other.direction)) / cross
        apex = (one.middle[0] + along * math.cos(one.direction), one.middle[1] + along * math.sin(one.direction))
        to_one, to_other = (math.atan2(arm.middle[1] - apex[1], arm.middle[0] - apex[0]) for arm in (one, other))
        between = wrap_angle(to_other - to_one)
        if abs(abs(between) - self.angle) > self.tolerance:
            return None
        inwards = wrap_angle(to_one + 0.5 * between + math.pi)
        away = apex[0] * math.cos(inwards) + apex[1] * math.sin(inwards)
        return Pose2D(*apex, inwards) if away > 0.0 else None
