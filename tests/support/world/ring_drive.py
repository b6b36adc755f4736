"""Simulated drive round a small ring of corridors, twice, with true poses."""

from functools import cache

import numpy as np

from benchmarks.mapping.simulated_drive import SimulatedDrive, simulate

OUTER, INNER = (0.0, 0.0, 12.0, 8.0), (2.5, 2.5, 9.5, 5.5)
"""Rectangles of the walls: x0, y0, x1, y1 [m]."""

PILLARS = (
    (4.0, 0.0, 4.4, 0.3),
    (11.6, 3.0, 12.0, 3.5),
    (6.0, 7.6, 7.0, 8.0),
    (0.0, 5.0, 0.3, 5.4),
    (8.0, 2.2, 8.5, 2.5),
)
"""Rectangles that stand out from the walls, so that no part of the ring looks like another."""

LAP = ((1.2, 1.2), (10.8, 1.2), (10.8, 6.8), (1.2, 6.8))


def rectangle(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    """Return the four edges of a rectangle."""
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


@cache
def ring_drive(laps: int = 2) -> SimulatedDrive:
    """Return the drive; the odometry drifts by about a metre."""
    walls = np.array([edge for sides in (OUTER, INNER, *PILLARS) for edge in rectangle(*sides)])
    return simulate(walls, np.array([*LAP * laps, LAP[0]]), 4, beams=90)
