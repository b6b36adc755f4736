"""A small room that a robot drives round again and again, and in which a box is moved."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import SimulatedDrive, simulate

ROOM = (0.0, 0.0, 6.0, 5.0)
"""Rectangle of the walls: x0, y0, x1, y1 [m]."""

PILLARS = ((0.0, 3.0, 0.3, 3.5), (2.0, 0.0, 2.6, 0.3), (5.6, 1.2, 6.0, 1.5), (4.2, 4.7, 5.2, 5.0))
"""Rectangles that stand out from the walls."""

BEFORE, AFTER = (2.6, 2.2, 3.2, 2.8), (0.0, 0.0, 0.6, 0.6)
"""Rectangles of the box: in the middle of the room, and then in a corner."""

LAP = ((1.4, 1.2), (4.4, 1.2), (4.4, 3.8), (1.4, 3.8))
"""Way points of a lap [m]."""


def room(*boxes: tuple[float, float, float, float]) -> NDArray[np.float64]:
    """Return the walls (n, 4) of the room with boxes: x0, y0, x1, y1 [m]."""
    return np.array([edge for sides in (ROOM, *PILLARS, *boxes) for edge in _rectangle(*sides)])


def changing_drive(walls: list[NDArray[np.float64]], beams: int = 180) -> SimulatedDrive:
    """Return a drive of a lap for each element of ``walls`` (n, 4), in which the room looks like that."""
    way = np.array([*LAP * len(walls), LAP[0]])
    whole = simulate(walls[0], way, 4, beams=beams)
    ends = [len(whole.log.stamps) * (lap + 1) // len(walls) for lap in range(len(walls))]
    for lap in range(1, len(walls)):
        if walls[lap] is not walls[0]:
            part = slice(ends[lap - 1], ends[lap])
            whole.log.ranges[part] = simulate(walls[lap], way, 4, beams=beams).log.ranges[part]
    return whole


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]
