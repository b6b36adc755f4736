"""Pose tracker: corrects the pose of the particle filter by aligning scans with the map.

Röwekämper, Sprunk, Tipaldi, Stachniss, Pfaff, Burgard, *On the Position Accuracy of Mobile Robot Localization based on
Particle Filters combined with Scan Matching* (2012). Particles keep several hypotheses and find a lost robot, but their
mean is coarse. And they cannot follow a robot that stands while its odometry turns: they are moved by that turn.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_estimate import PoseEstimate
from ppaas.localization.scan_match import Alignment, ScanMatch, align
from ppaas.localization.sensor_model import ends_at_people

POINTS, FEWEST_POINTS = 120, 10
"""Largest and smallest number of points of a scan that are aligned."""

FEWEST_SEEN = 0.33
"""Part of the points that must not end at people: those left over were chosen by the expected pose, and so fit it."""

LEAST_FIT = 0.5
"""Fit below which an alignment is not used: most of what the laser sees is not on the map."""

SOON, LATE = 1.0, 10.0
"""Time between two alignments without an update of the particles, if odometry moves, and if it does not [s]."""

MOVED, TURNED = 0.02, 0.01
"""Motion by odometry that calls for an alignment after `SOON` [m, rad]."""

STILL = 0.002
"""Standard deviation of the position if odometry did not move [m]."""

SLIP, SWERVE, TURN_SLIP = 0.3, 0.05, 0.02
"""Standard deviation of the position per metre, and of the heading per metre and per radian [m/m, rad/m, rad/rad]."""

SLIPPED, SETTLING = 4.0, 0.05
"""Number of standard deviations beyond which a robot slipped or was pushed, and the largest one that follows it [m]."""

MOST_SPREAD = np.array((0.1, 0.1, 0.2))
"""Largest standard deviation that is taken from the particles [m, m, rad]."""

APART, APART_TURN = 0.4, 0.35
"""Difference from the particles above which the tracker starts again from them [m, rad]."""

ONE_PLACE = 0.9
"""Part of the weight of the particles that must be at one place to start from them."""

UNKNOWN_HEADING = math.pi / math.sqrt(3.0)
"""Standard deviation of a heading of which nothing is known [rad]."""


@dataclass(frozen=True, slots=True)
class _Fix:
    """An alignment.

    Parameters
    ----------
    pose, odom : Pose2D
        Pose in the map frame, and in the odometry frame.
    at : float
        Time [s].
    position : float
        Standard deviation of the position if the robot slipped or was pushed, halved with each alignment since [m].
    heading : float
        Standard deviation of the heading [rad].
    """

    pose: Pose2D
    odom: Pose2D
    at: float
    position: float
    heading: float


class PoseTracker:
    """Follows the pose of a robot from alignment to alignment.

    Between two alignments the robot moves as odometry says, within what a robot slips. Its heading may also turn by
    ``odom_drift`` times the time that has passed, since a gyro drifts while the robot stands.

    Parameters
    ----------
    layers : MapLayers
        The map.
    parameters : AmclParameters
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters) -> None:
        self._parameters, self._drift = parameters, parameters.odom_drift
        self.use_layers(layers)
        self.forget()

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map by another in the same frame; the pose is followed from the last alignment."""
        self._layers, self._match = layers, ScanMatch(layers, self._parameters)

    def forget(self) -> None:
        """Start over from the particles with the next alignment."""
        self._fix: _Fix | None = None
        self._tried: tuple[Pose2D, float] | None = None
        self._known_at: float | None = None
        self._updated_at = -math.inf

    def rebase(self, jump: Pose2D) -> None:
        """Continue after a reset of the odometry; ``jump`` is the pose of the new odometry frame in the old one."""
        back = jump.inverse()
        if self._fix is not None:
            self._fix = replace(self._fix, odom=back @ self._fix.odom)
        if self._tried is not None:
            self._tried = back @ self._tried[0], self._tried[1]

    def due(self, odom: Pose2D, now: float) -> bool:
        """Return whether to align a scan although the particles need no update.

        Parameters
        ----------
        odom : Pose2D
            Pose of the robot in the odometry frame.
        now : float
            Current time [s].
        """
        if self._tried is None:
            return False
        last, at = self._tried
        moved = last.distance_to(odom) >= MOVED or abs(wrap_angle(odom.theta - last.theta)) >= TURNED
        settling = self._fix is not None and self._fix.position > STILL
        return now - at >= (SOON if moved or settling else LATE)

    def unsure(self, now: float) -> float:
        """Return the standard deviation of the heading by the drift since scans last told it [rad]."""
        if self._known_at is None:
            return 0.0
        known = 0.0 if self._fix is None else self._fix.heading
        return min(known + self._drift * max(now - self._known_at, 0.0), UNKNOWN_HEADING)

    def note_update(self, now: float) -> float:
        """Record that the particles are updated; return the standard deviation of their turn by drift since [rad].

        Updates of a robot that drives follow each other closely and determine its heading. Updates of a robot that
        stands are many seconds apart, and one scan alone hardly determines it.
        """
        drifted = self._drift * min(max(now - self._updated_at, 0.0), UNKNOWN_HEADING / max(self._drift, 1e-9))
        if self._known_at is None or now - self._updated_at < LATE:
            self._known_at = now
        first, self._updated_at = self._updated_at == -math.inf, now
        return 0.0 if first else drifted

    def align(self, believed: PoseEstimate, odom: Pose2D, points: NDArray[np.float64], now: float) -> Pose2D | None:
        """Return the pose of the robot by a scan, or None if the scan does not determine it.

        Parameters
        ----------
        believed : PoseEstimate
            Estimate of the particles, moved to the time of the scan by odometry.
        odom : Pose2D
            Pose of the robot in the odometry frame.
        points : (n, 2) array
            End points of beams in the robot's frame [m].
        now : float
            Current time [s].
        """
        self._tried = odom, now
        expected, spread = self._expected(believed, odom, now)
        # Beams that end at people do not determine the pose.
        seen = points[~ends_at_people(expected, points, self._layers)]
        fewest = max(FEWEST_POINTS, FEWEST_SEEN * len(points))
        if (self._fix is None and believed.share < ONE_PLACE) or len(seen) < fewest:
            return None
        found = align(self._match, seen, expected, spread)
        if found.fit < LEAST_FIT:
            return None
        slipped = found.pose.distance_to(expected) > SLIPPED * spread[0]
        self._fix = _Fix(found.pose, odom, now, self._settling(found, slipped=slipped), found.deviations[2])
        self._known_at = now
        return found.pose

    def _settling(self, found: Alignment, *, slipped: bool) -> float:
        """Return the standard deviation of the position beyond the next motion's [m]."""
        if self._fix is None:
            return 0.0
        return min(max(found.deviations[:2]), SETTLING) if slipped else 0.5 * self._fix.position

    def _expected(self, believed: PoseEstimate, odom: Pose2D, now: float) -> tuple[Pose2D, NDArray[np.float64]]:
        """Return the expected pose and its standard deviations, from the last alignment or else from the particles."""
        fix = self._fix
        if fix is not None:
            motion = fix.odom.inverse() @ odom
            expected, metres = fix.pose @ motion, math.hypot(motion.x, motion.y)
            if not _are_apart(expected, believed.pose):
                drifted = self._drift * max(now - fix.at, 0.0)
                turned = fix.heading + drifted + SWERVE * metres + TURN_SLIP * abs(motion.theta)
                away = STILL + fix.position + SLIP * metres
                return expected, np.array((away, away, min(turned, UNKNOWN_HEADING)))
            self._fix = None
        drifted = self.unsure(now)
        spread = np.minimum(np.sqrt(np.diag(believed.covariance)), MOST_SPREAD)
        return believed.pose, np.maximum(spread + np.array((0.0, 0.0, drifted)), STILL)


def _are_apart(pose: Pose2D, other: Pose2D) -> bool:
    return pose.distance_to(other) > APART or abs(wrap_angle(pose.theta - other.theta)) > APART_TURN
