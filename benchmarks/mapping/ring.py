"""A small ring of corridors, in which no part looks like another: mapped in a second or two."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import SimulatedDrive, simulate

OUTER, INNER = (0.0, 0.0, 12.0, 8.0), (2.5, 2.5, 9.5, 5.5)
"""Rectangles of the walls: x0, y0, x1, y1 [m]."""

PILLARS = (
    (4.0, 0.0, 4.4, 0.3), (11.6, 3.0, 12.0, 3.5), (6.0, 7.6, 7.0, 8.0), (0.0, 5.0, 0.3, 5.4), (8.0, 2.2, 8.5, 2.5),
)  # fmt: skip
"""Rectangles that stand out from the walls."""

LAP = ((1.2, 1.2), (10.8, 1.2), (10.8, 6.8), (1.2, 6.8))
"""Way points of a lap [m]."""


def walls() -> NDArray[np.float64]:
    """Return the walls (n, 4): x0, y0, x1, y1 [m]."""
    return np.array([edge for sides in (OUTER, INNER, *PILLARS) for edge in _rectangle(*sides)])


def ring_drive(laps: int = 2) -> SimulatedDrive:
    """Return a drive round the ring; the odometry drifts by about a metre."""
    return simulate(walls(), np.array([*LAP * laps, LAP[0]]), 4, beams=90)


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]
