"""Scan smoothing: averages neighbouring beams that hit the same surface.

Each beam marks the cell of its endpoint. Of many noisy beams on a near surface, some always end too close, so without
smoothing a gap appears narrower by a few standard deviations of the laser on both sides.
"""

import numpy as np

from ppaas.costmap.obstacle_layer import LaserReading

ARC = 0.04
"""Maximum lateral distance between the endpoints of averaged beams [m]."""
DEPTH = 0.08
"""Maximum difference between the ranges of averaged beams [m]."""
MOST = 12
"""Maximum number of averaged beams on each side."""


def smoothed(reading: LaserReading) -> LaserReading:
    """Return a reading in which each range is the mean of neighbouring ranges on the same surface.

    Parameters
    ----------
    reading : LaserReading
        Reading whose beams are in angular order and evenly spaced.

    Returns
    -------
    LaserReading
        Invalid ranges and those without a hit are unchanged, and are not part of any mean.
    """
    ranges = reading.ranges
    hit = np.isfinite(ranges) & (ranges > 0.0)
    if np.count_nonzero(hit) < 2:
        return reading
    spacing = abs(float(reading.angles[1] - reading.angles[0]))
    known = np.where(hit, ranges, np.nan)
    # Number of beams within the arc, at the range of each beam.
    reach = np.zeros(len(ranges), np.int64)
    reach[hit] = np.minimum(ARC / np.maximum(ranges[hit] * spacing, ARC / MOST), MOST)
    total, count = known.copy(), np.ones(len(ranges))
    for offset in range(1, min(int(reach.max()), len(ranges) - 1) + 1):
        low, high = slice(None, -offset), slice(offset, None)
        same = np.abs(known[high] - known[low]) <= DEPTH
        for here, there in ((low, high), (high, low)):
            counts = same & (reach[here] >= offset)
            total[here] += np.where(counts, known[there], 0.0)
            count[here] += counts
    return LaserReading(reading.origin, reading.angles, np.where(hit, total / count, ranges))
