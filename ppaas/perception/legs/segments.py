"""Segments of a laser scan: runs of successive hits on one surface, with the shape of each.

Source: Arras, Mozos, Burgard, "Using boosted features for the detection of people in 2D range data" (ICRA 2007),
section III: jump distance segmentation, and width, curvature and depth gaps as features.

Likelihoods of shapes are logarithms of odds, so that they add up: 0 means that both are as likely. Features as in Arras
et al. (ICRA 2007) and Leigh et al., "Person tracking and following with 2D laser scanners" (ICRA 2015).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.obstacle_layer import LaserReading

Floats = NDArray[np.float64]
# -- segments of a laser scan ------------------------------------------------------------------------------------------

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ScanSegments:
    """Segments of a scan, in the order of the beams.

    Parameters
    ----------
    points : (n, 2) array
        Points of all hits, x, y in the frame of the laser's origin [m].
    first, last : (m,) int array
        Rows of ``points`` at which each segment begins and ends, both included.
    range : (m,) array
        Mean range [m].
    spacing : (m,) array
        Distance between two beams at that range [m].
    width : (m,) array
        Width across the line of sight [m]: of the hits, and half a spacing on each side.
    depth : (m,) array
        Difference between the largest and the least range [m].
    bend : (m,) array
        Distance by which the middle of the segment is nearer than the mean of its ends [m].
    gap_before, gap_after : (m,) array
        Range of the neighbouring beam minus the range of the segment's end [m]: positive if the background is
        behind the edge, negative if a nearer object or the end of the field of view hides the rest; infinite if
        nothing was hit.
    """

    points: Floats
    first: Ints
    last: Ints
    range: Floats
    spacing: Floats
    width: Floats
    depth: Floats
    bend: Floats
    gap_before: Floats
    gap_after: Floats

    def __len__(self) -> int:
        return len(self.first)

    @property
    def count(self) -> Ints:
        """(m,) number of beams that hit each segment."""
        return self.last - self.first + 1


def segments_of(reading: LaserReading, *, gap: float, longest: float) -> ScanSegments:
    """Return the segments of a scan.

    Parameters
    ----------
    reading : LaserReading
    gap : float
        Distance between two successive hits, beyond the spacing of the beams, from which a segment ends [m].
    longest : float
        Longest range that is used [m].
    """
    step, circle = spacing_of(reading), is_circle(reading)
    if circle:
        reading = _from_a_break(reading, gap)
    with np.errstate(invalid="ignore"):
        hit = np.flatnonzero((reading.ranges > 0.0) & (reading.ranges < longest))
    ranges, heading = reading.ranges[hit], reading.angles[hit] + reading.origin.theta
    points = np.stack((reading.origin.x + ranges * np.cos(heading), reading.origin.y + ranges * np.sin(heading)), 1)
    if not len(hit):
        return _NONE
    apart = np.hypot(*np.diff(points, axis=0).T)
    # One beam without a reading does not end a segment; more do.
    ends = (apart > gap + step * ranges[1:]) | (np.diff(hit) > 2)
    first = np.concatenate(([0], np.flatnonzero(ends) + 1))
    last = np.concatenate((np.flatnonzero(ends), [len(hit) - 1]))
    before, after = (_ranges_at(reading, beams, circle) for beams in (hit[first] - 1, hit[last] + 1))
    return _described(_Hits(points, ranges, reading.angles[hit], step), first, last, before, after)


def spacing_of(reading: LaserReading) -> float:
    """Return the angle between two beams [rad]."""
    return abs(float(reading.angles[-1] - reading.angles[0])) / max(len(reading.angles) - 1, 1)


def is_circle(reading: LaserReading) -> bool:
    """Return whether the last and the first beam are neighbours."""
    count = len(reading.angles)
    return count >= 3 and spacing_of(reading) * (count + 1) >= 2.0 * np.pi


def _from_a_break(reading: LaserReading, gap: float) -> LaserReading:
    """Return a scan of a full circle that begins between two surfaces, if there is such a place."""
    jumps = np.abs(np.diff(np.nan_to_num(reading.ranges, nan=0.0, posinf=1e3)))
    begin = int(np.argmax(jumps)) + 1
    if jumps[begin - 1] <= gap:
        return reading
    return LaserReading(reading.origin, np.roll(reading.angles, -begin), np.roll(reading.ranges, -begin))


class _Hits(NamedTuple):
    """Points, ranges [m] and angles [rad] of the beams that hit something, and the angle between two beams [rad]."""

    points: Floats
    ranges: Floats
    angles: Floats
    step: float


def _described(hits: _Hits, first: Ints, last: Ints, before: Floats, after: Floats) -> ScanSegments:
    """Return the segments, from the ranges of the beams before and after each."""
    ranges, step = hits.ranges, hits.step
    mean = np.add.reduceat(ranges, first) / (last - first + 1)
    middle = 0.5 * (ranges[(first + last) // 2] + ranges[(first + last + 1) // 2])
    angle = np.abs(_turn(hits.angles[last] - hits.angles[first]))
    return ScanSegments(
        hits.points, first, last, mean, step * mean,
        width=2.0 * mean * np.sin(0.5 * np.minimum(angle + step, np.pi)),
        depth=np.maximum.reduceat(ranges, first) - np.minimum.reduceat(ranges, first),
        bend=0.5 * (ranges[first] + ranges[last]) - middle,
        gap_before=before - ranges[first], gap_after=after - ranges[last],
    )  # fmt: skip


def _ranges_at(reading: LaserReading, beams: Ints, circle: bool) -> Floats:
    """Return the ranges of beams; infinite for those without a reading, and 0 beyond the ends of the field of view."""
    count = len(reading.ranges)
    values: Floats = np.nan_to_num(reading.ranges[beams % count], nan=np.inf, posinf=np.inf)
    values = np.where(values > 0.0, values, np.inf)
    return values if circle else np.where((beams >= 0) & (beams < count), values, 0.0)


def _turn(angles: Floats) -> Floats:
    turned: Floats = np.mod(angles + np.pi, 2.0 * np.pi) - np.pi
    return turned


_NO_NUMBERS = np.empty(0)
_NONE = ScanSegments(
    np.empty((0, 2)), np.empty(0, np.int64), np.empty(0, np.int64), _NO_NUMBERS, _NO_NUMBERS, _NO_NUMBERS, _NO_NUMBERS,
    _NO_NUMBERS, _NO_NUMBERS, _NO_NUMBERS,
)  # fmt: skip


# -- likelihood that a segment of a scan is a leg, or two legs side by side, from its shape ----------------------------

LEG_WIDTH, LEG_SPREAD, LEG_THINNER = 0.12, 0.035, 0.022
"""Width of a leg in trousers at the height of a laser, and its standard deviations towards thicker and thinner legs
[m]: legs of chairs and tables are thinner."""

BOTH_WIDTH, BOTH_SPREAD = 0.3, 0.09
"""Width of two legs side by side that are one segment, and its standard deviation [m]."""

DEEPEST = 0.2
"""Difference of ranges above which a segment is a slanted surface [m]."""

CLEAR = 0.1
"""Distance of the background behind an edge from which the edge belongs to the object [m]."""

CURVED = 0.015
"""Bend above which a segment is round [m]; a leg with a radius of 6 cm has 0.02 to 0.05 m."""

ROUND, ROUNDEST = 0.08, 0.3
"""Bend by width above which a wide segment is one round object, such as a column or another robot, rather than two
legs, and that from which it certainly is."""

LEAST = -6.0
"""Least value."""


def leg_evidence(segments: ScanSegments) -> Floats:
    """Return the logarithm of the odds that each segment is one leg, (m,) array."""
    own = np.where(segments.width < LEG_WIDTH, LEG_THINNER, LEG_SPREAD)
    spread = np.hypot(own, 0.45 * segments.spacing)
    odds = 1.5 - 0.5 * ((segments.width - LEG_WIDTH) / spread) ** 2
    odds += _edges(segments) + _roundness(segments)
    odds -= 2.0 * (segments.depth > DEEPEST)
    # A single hit shows nothing of the shape.
    odds -= 2.2 * (segments.count == 1)
    return np.maximum(odds, LEAST)


def both_evidence(segments: ScanSegments) -> Floats:
    """Return the logarithm of the odds that each segment is two legs side by side, (m,) array."""
    spread = np.hypot(BOTH_SPREAD, 0.45 * segments.spacing)
    odds = -0.5 * ((segments.width - BOTH_WIDTH) / spread) ** 2
    odds += _edges(segments)
    odds -= 5.0 * np.clip((segments.bend / np.maximum(segments.width, 1e-6) - ROUND) / (ROUNDEST - ROUND), 0.0, 1.0)
    odds -= 2.0 * (segments.depth > 2.0 * DEEPEST)
    odds -= 3.0 * (segments.count < 4)
    return np.maximum(odds, LEAST)


def _edges(segments: ScanSegments) -> Floats:
    """Return the evidence of the edges: legs stand free; a hidden edge may belong to any surface."""
    before, after = segments.gap_before, segments.gap_after
    clear = (before > CLEAR).astype(np.float64) + (after > CLEAR)
    hidden = (before < -CLEAR).astype(np.float64) + (after < -CLEAR)
    evidence: Floats = 0.25 * clear - 1.0 * hidden
    return evidence


def _roundness(segments: ScanSegments) -> Floats:
    """Return the evidence of the bend, which needs some beams: a leg is round, a flat board is not."""
    bent = np.clip((segments.bend - CURVED) / CURVED, -1.0, 1.0)
    return np.where(segments.count >= 4, bent, 0.0)
