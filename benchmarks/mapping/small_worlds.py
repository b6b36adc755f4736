"""Small worlds that are mapped in seconds: a ring in which no part looks like another, and a room with a box."""

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


# -- a small room that a robot drives round again and again, and in which a box is moved -------------------------------

ROOM = (0.0, 0.0, 6.0, 5.0)
"""Rectangle of the walls: x0, y0, x1, y1 [m]."""

ROOM_PILLARS = ((0.0, 3.0, 0.3, 3.5), (2.0, 0.0, 2.6, 0.3), (5.6, 1.2, 6.0, 1.5), (4.2, 4.7, 5.2, 5.0))
"""Rectangles that stand out from the walls."""

BEFORE, AFTER = (2.6, 2.2, 3.2, 2.8), (0.0, 0.0, 0.6, 0.6)
"""Rectangles of the box: in the middle of the room, and then in a corner."""

ROOM_LAP = ((1.4, 1.2), (4.4, 1.2), (4.4, 3.8), (1.4, 3.8))
"""Way points of a lap [m]."""


def room(*boxes: tuple[float, float, float, float]) -> NDArray[np.float64]:
    """Return the walls (n, 4) of the room with boxes: x0, y0, x1, y1 [m]."""
    return np.array([edge for sides in (ROOM, *ROOM_PILLARS, *boxes) for edge in _rectangle(*sides)])


def changing_drive(walls: list[NDArray[np.float64]], beams: int = 180) -> SimulatedDrive:
    """Return a drive of a lap for each element of ``walls`` (n, 4), in which the room looks like that."""
    way = np.array([*ROOM_LAP * len(walls), ROOM_LAP[0]])
    whole = simulate(walls[0], way, 4, beams=beams)
    ends = [len(whole.log.stamps) * (lap + 1) // len(walls) for lap in range(len(walls))]
    for lap in range(1, len(walls)):
        if walls[lap] is not walls[0]:
            part = slice(ends[lap - 1], ends[lap])
            whole.log.ranges[part] = simulate(walls[lap], way, 4, beams=beams).log.ranges[part]
    return whole
