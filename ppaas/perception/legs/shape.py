"""Likelihood that a segment of a scan is a leg, or two legs side by side, from its shape.

All are logarithms of odds, so that they add up: 0 means that both are as likely. Features as in Arras et al. (ICRA
2007) and Leigh et al., "Person tracking and following with 2D laser scanners" (ICRA 2015).
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.legs.segments import Segments

Floats = NDArray[np.float64]

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


def leg_evidence(segments: Segments) -> Floats:
    """Return the logarithm of the odds that each segment is one leg, (m,) array."""
    own = np.where(segments.width < LEG_WIDTH, LEG_THINNER, LEG_SPREAD)
    spread = np.hypot(own, 0.45 * segments.spacing)
    odds = 1.5 - 0.5 * ((segments.width - LEG_WIDTH) / spread) ** 2
    odds += _edges(segments) + _roundness(segments)
    odds -= 2.0 * (segments.depth > DEEPEST)
    # A single hit shows nothing of the shape.
    odds -= 2.2 * (segments.count == 1)
    return np.maximum(odds, LEAST)


def both_evidence(segments: Segments) -> Floats:
    """Return the logarithm of the odds that each segment is two legs side by side, (m,) array."""
    spread = np.hypot(BOTH_SPREAD, 0.45 * segments.spacing)
    odds = -0.5 * ((segments.width - BOTH_WIDTH) / spread) ** 2
    odds += _edges(segments)
    odds -= 5.0 * np.clip((segments.bend / np.maximum(segments.width, 1e-6) - ROUND) / (ROUNDEST - ROUND), 0.0, 1.0)
    odds -= 2.0 * (segments.depth > 2.0 * DEEPEST)
    odds -= 3.0 * (segments.count < 4)
    return np.maximum(odds, LEAST)


def _edges(segments: Segments) -> Floats:
    """Return the evidence of the edges: legs stand free; a hidden edge may belong to any surface."""
    before, after = segments.gap_before, segments.gap_after
    clear = (before > CLEAR).astype(np.float64) + (after > CLEAR)
    hidden = (before < -CLEAR).astype(np.float64) + (after < -CLEAR)
    evidence: Floats = 0.25 * clear - 1.0 * hidden
    return evidence


def _roundness(segments: Segments) -> Floats:
    """Return the evidence of the bend, which needs some beams: a leg is round, a flat board is not."""
    bent = np.clip((segments.bend - CURVED) / CURVED, -1.0, 1.0)
    return np.where(segments.count >= 4, bent, 0.0)
