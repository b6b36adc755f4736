"""Detection of people in laser scans by their legs."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.perception.legs.pairing import Legs, people_of
from ppaas.perception.legs.parameters import LegDetectorParameters
from ppaas.perception.legs.seen_through import SeenThrough
from ppaas.perception.legs.segments import Segments, segments_of
from ppaas.perception.legs.shape import both_evidence, leg_evidence
from ppaas.perception.unmapped_objects import unmapped

Floats = NDArray[np.float64]

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

    def _useful(self, segments: Segments, known: MapInFrame | None) -> NDArray[np.int64]:
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


def _centres(segments: Segments, laser: Pose2D) -> Floats:
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
