"""Detection of people in laser scans: legs form pairs, and what stands where a beam passed before has moved.

Source of the memory of scans: "free-space violations", as in Leigh et al., "Person tracking and following with 2D
laser scanners" (ICRA 2015), where a local occupancy grid holds the free space.
"""

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.perception.legs.parameters import LegDetectorParameters
from ppaas.perception.legs.segments import ScanSegments, both_evidence, is_circle, leg_evidence, segments_of, spacing_of
from ppaas.perception.unmapped_objects import unmapped

Floats = NDArray[np.float64]

# -- pairs of legs -----------------------------------------------------------------------------------------------------

STANDING, STRIDING = 0.4, 0.8
"""Distance between the legs of a person who stands, and the largest one of a person who walks [m]."""

STRIDE_SPREAD = 0.15
"""Standard deviation of the distance beyond `STANDING` [m]."""

AROUND = 0.7
"""Distance from the middle of two legs within which further legs speak against a person: tables have four [m]."""

LIKE = -0.5
"""Evidence from which a segment counts as like a leg."""

BONUS, ALONE = 1.0, -3.0
"""Evidence of a second leg, and of a leg alone, whose second one is hidden or not a leg at all."""


class Legs(NamedTuple):
    """One or two legs of a person.

    Parameters
    ----------
    x, y : float
        Middle of the legs [m].
    evidence : float
        Logarithm of the odds that they belong to a person.
    apart : float
        Distance between the two legs [m]; 0 for one leg, or for two that are one segment.
    both : bool
        Whether both legs are seen.
    """

    x: float
    y: float
    evidence: float
    apart: float
    both: bool


def people_of(centres: Floats, legs: Floats, motion: Floats) -> list[Legs]:
    """Join legs to people, the best pairs first; each leg belongs to one person.

    Parameters
    ----------
    centres : (n, 2) array
        Centres of the legs [m].
    legs : (n,) array
        Evidence that each is a leg.
    motion : (n,) array
        Evidence that it has moved.
    """
    pairs = _pairs(centres, legs + motion)
    used: set[int] = set()
    found = []
    for evidence, i, k in pairs:
        if i in used or k in used:
            continue
        middle = 0.5 * (centres[i] + centres[k])
        others = _others(middle, centres, legs, motion, (i, k))
        if evidence - others <= max(legs[i] + motion[i], legs[k] + motion[k]) + ALONE:
            continue
        used |= {i, k}
        x, y = middle.tolist()
        found.append(Legs(x, y, evidence - others, float(np.hypot(*(centres[i] - centres[k]))), True))
    for i in sorted(set(range(len(centres))) - used):
        x, y = centres[i].tolist()
        found.append(Legs(x, y, float(legs[i] + motion[i]) + ALONE, 0.0, False))
    return found


def _pairs(centres: Floats, evidence: Floats) -> list[tuple[float, int, int]]:
    """Return the pairs that may be the legs of one person, with their evidence, the best first."""
    i, k = np.triu_indices(len(centres), 1)
    apart = np.hypot(*(centres[i] - centres[k]).T)
    near = apart <= STRIDING
    i, k, apart = i[near], k[near], apart[near]
    odds = evidence[i] + evidence[k] + BONUS - (np.maximum(apart - STANDING, 0.0) / STRIDE_SPREAD) ** 2
    # Of pairs that are as likely, the nearer legs belong to one person.
    order = np.argsort(-(odds - apart), kind="stable")
    return list(zip(odds[order].tolist(), i[order].tolist(), k[order].tolist(), strict=True))


def _others(middle: Floats, centres: Floats, legs: Floats, motion: Floats, pair: tuple[int, int]) -> float:
    """Return the evidence against a pair of further legs around it that do not move."""
    around = (np.hypot(*(centres - middle).T) < AROUND) & (legs > LIKE) & (motion <= 0.0)
    around[list(pair)] = False
    return float(around.sum())


# -- memory of the last scans, which shows what has moved --------------------------------------------------------------

PERIOD = 0.3
"""Least time between two scans that are kept [s]."""

LENGTH = 5
"""Number of scans that are kept."""

BEYOND = 0.25
"""Distance behind a point beyond which a beam must have ended [m]."""

HALF_WIDTH = 0.08
"""Half of the width around a point in which all beams must have passed [m]."""


class SeenThrough:
    """Last scans of one laser, with the poses of the laser in the frame of the odometry."""

    def __init__(self) -> None:
        self._scans: deque[tuple[float, LaserReading]] = deque(maxlen=LENGTH)

    def add(self, reading: LaserReading, stamp: float) -> None:
        """Add a scan in the frame of the odometry, at its time [s], unless one of a moment before is kept.

        If the clock was set back, the scans before are forgotten.
        """
        if self._scans and stamp < self._scans[-1][0]:
            self._scans.clear()
        if not self._scans or stamp - self._scans[-1][0] >= PERIOD:
            self._scans.append((stamp, reading))

    def share(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the kept scans that saw through each point, from 0 to 1.

        Parameters
        ----------
        points : (n, 2) array
            x, y in the frame of the odometry [m].

        Returns
        -------
        (n,) array
        """
        if not self._scans or not len(points):
            return np.zeros(len(points))
        passed = np.stack([_passed(reading, points) for _, reading in self._scans])
        share: NDArray[np.float64] = passed.mean(axis=0)
        return share


def _passed(reading: LaserReading, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether all beams of a scan towards each point ended behind it, or hit nothing."""
    origin: Pose2D = reading.origin
    x, y = points[:, 0] - origin.x, points[:, 1] - origin.y
    away, step = np.hypot(x, y), spacing_of(reading)
    if step <= 0.0:
        return np.zeros(len(points), bool)
    sign = 1.0 if reading.angles[-1] >= reading.angles[0] else -1.0
    bearing = np.mod(sign * (np.arctan2(y, x) - origin.theta - reading.angles[0]), 2.0 * np.pi)
    middle = np.rint(bearing / step).astype(np.int64)
    half = np.ceil(HALF_WIDTH / np.maximum(away, HALF_WIDTH) / step).astype(np.int64)
    widest = int(half.max())
    offsets = np.arange(-widest, widest + 1)
    beams = middle[:, None] + offsets
    count = len(reading.ranges)
    known = np.ones_like(beams, bool) if is_circle(reading) else (beams >= 0) & (beams < count)
    ranges = reading.ranges[beams % count]
    # NaN compares as false: a beam without a reading has seen nothing.
    with np.errstate(invalid="ignore"):
        beyond = known & (ranges > (away + BEYOND)[:, None])
    passed: NDArray[np.bool_] = (beyond | (np.abs(offsets) > half[:, None])).all(axis=1)
    return passed


# -- detection of people in laser scans by their legs ------------------------------------------------------------------

MAP_MARGIN = 0.12
"""Distance from what is in the map up to which a hit is on it [m]; a wall a person leans on hides the legs."""

MOVED = 3.0
"""Evidence that an object where all earlier scans saw free space is a person: little else moves."""

DEPTH_OF_CENTRE = 0.6 * 0.06
"""Distance from the mean of the hits on a leg to its centre [m]: 2/π of its radius, for the whole half."""

SIGMA_BOTH, SIGMA_ALONE, SIGMA_RANGE = 0.06, 0.15, 0.01
"""Standard deviations of the position by two legs and by one [m], and their growth with the range [m/m]."""


class LegDetection(NamedTuple):
    """A person whose legs a laser sees.

    Parameters
    ----------
    x, y : float
        Position, in the frame of the reading's origin [m].
    sigma : float
        Standard deviation of the position, along both axes [m].
    score : float
        Probability that it is a person, from 0 to 1.
    may_begin : bool
        Whether it suffices to begin a track.
    """

    x: float
    y: float
    sigma: float
    score: float
    may_begin: bool


@dataclass(frozen=True, slots=True)
class MapInFrame:
    """Map whose obstacles are not people.

    Parameters
    ----------
    layers : MapLayers
    pose : Pose2D
        Pose of the frame of the scans in the frame of the map.
    """

    layers: MapLayers
    pose: Pose2D

    def shows_not(self, points: Floats) -> NDArray[np.bool_]:
        """Return which of the (n, 2) points are in free space of the map."""
        cos, sin = math.cos(self.pose.theta), math.sin(self.pose.theta)
        turned = points @ np.array(((cos, sin), (-sin, cos)))
        return unmapped(turned + np.array(self.pose[:2]), self.layers, MAP_MARGIN)


class LegDetector:
    """Detector of people in the scans of one laser.

    Parameters
    ----------
    parameters : LegDetectorParameters
    """

    def __init__(self, parameters: LegDetectorParameters) -> None:
        self._parameters = parameters
        self._earlier = SeenThrough()

    def detect(self, reading: LaserReading, stamp: float, known: MapInFrame | None = None) -> list[LegDetection]:
        """Return the people in a scan.

        Parameters
        ----------
        reading : LaserReading
            Scan in a frame that does not jump, such as the odometry's.
        stamp : float
            Its time [s].
        known : MapInFrame, optional
            The map, if the robot is localized.
        """
        own = self._parameters
        segments = segments_of(reading, gap=own.connection_threshold, longest=own.max_range)
        useful = self._useful(segments, known)
        centres = _centres(segments, reading.origin)[useful]
        # The beams of a scan before may have passed beside an object that only one beam hits.
        motion = MOVED * self._earlier.share(centres) * np.where(segments.count[useful] > 1, 1.0, 0.35)
        self._earlier.add(reading, stamp)
        legs = leg_evidence(segments)[useful]
        both = both_evidence(segments)[useful]
        found = [*people_of(centres, legs, motion), *_merged(centres, both, motion)]
        return self._detections(_without_twins(found), reading.origin)

    def _useful(self, segments: ScanSegments, known: MapInFrame | None) -> NDArray[np.int64]:
        """Return the segments that may be legs: near enough, with enough beams, and not in the map."""
        own = self._parameters
        useful = (segments.range >= own.min_range) & (segments.count >= own.min_points_per_group)
        useful &= np.maximum(leg_evidence(segments), both_evidence(segments)) > LEAST_EVIDENCE
        if known is not None and len(segments):
            free = known.shows_not(segments.points).astype(np.float64)
            useful &= np.add.reduceat(free, segments.first) > 0.5 * segments.count
        return np.flatnonzero(useful)

    def _detections(self, found: list[Legs], laser: Pose2D) -> list[LegDetection]:
        own, detections = self._parameters, []
        for legs in found:
            score = 1.0 / (1.0 + math.exp(-legs.evidence))
            away = math.hypot(legs.x - laser.x, legs.y - laser.y)
            if score < own.min_reliability or away > own.max_range:
                continue
            sigma = (SIGMA_BOTH if legs.both else SIGMA_ALONE) + SIGMA_RANGE * away
            detections.append(LegDetection(legs.x, legs.y, sigma, score, score >= own.leg_reliability_limit))
        return detections


LEAST_EVIDENCE = -4.0
"""Evidence below which a segment is neither one leg nor two [log odds]."""

TWINS = 0.35
"""Distance within which two detections are of one person [m]."""


def _centres(segments: ScanSegments, laser: Pose2D) -> Floats:
    """Return the (m, 2) centres of the objects: behind the mean of their hits."""
    if not len(segments):
        return np.empty((0, 2))
    middle: Floats = np.add.reduceat(segments.points, segments.first) / segments.count[:, None]
    away = middle - (laser.x, laser.y)
    centres: Floats = middle + DEPTH_OF_CENTRE * away / np.maximum(np.hypot(*away.T), 1e-6)[:, None]
    return centres


def _merged(centres: Floats, both: Floats, motion: Floats) -> list[Legs]:
    """Return the segments as people whose two legs are one segment."""
    return [
        Legs(x, y, evidence, 0.0, True)
        for (x, y), evidence in zip(centres.tolist(), (both + motion - 1.0).tolist(), strict=True)
    ]


def _without_twins(found: list[Legs]) -> list[Legs]:
    """Return the best of the detections that are of one person."""
    kept: list[Legs] = []
    for legs in sorted(found, key=lambda each: -each.evidence):
        if all(math.hypot(legs.x - other.x, legs.y - other.y) > max(TWINS, 0.5 * other.apart + 0.1) for other in kept):
            kept.append(legs)
    return kept
