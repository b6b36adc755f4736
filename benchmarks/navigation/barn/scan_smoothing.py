"""A scan with less noise: beams beside one another that hit the same thing are averaged.

Each beam marks the cell that it ended in. Of many noisy beams on one surface near by some always end too near, so
without this a gap seems narrower than it is, on both sides by some standard deviations of the laser.
"""

import numpy as np

from ppaas.costmap.obstacle_layer import LaserReading

ARC = 0.04
"""Beams that end so near beside one another may have hit the same thing [m]."""
DEPTH = 0.08
"""They have, if their ranges differ by no more [m]."""
MOST = 12
"""Beams to either side that are looked at."""


def smoothed(reading: LaserReading) -> LaserReading:
    """Return a reading in which each range is the mean of those on the same surface beside it.

    Parameters
    ----------
    reading : LaserReading
        Its beams are in order, and as far from one another as the first two.

    Returns
    -------
    LaserReading
        Beams that hit nothing, or have no reading, are as they were, and count for no other.
    """
    ranges = reading.ranges
    hit = np.isfinite(ranges) & (ranges > 0.0)
    if np.count_nonzero(hit) < 2:
        return reading
    spacing = abs(float(reading.angles[1] - reading.angles[0]))
    known = np.where(hit, ranges, np.nan)
    # How many beams lie within the arc, at the range of each.
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
