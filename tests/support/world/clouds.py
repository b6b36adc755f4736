"""Point clouds of simple places."""

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

FLOOR = 0.4
"""Height of the floor of the room [m]."""


def room_points(*, floor: bool = True, ceiling: bool = True) -> Points:
    """Return points each 4 cm of a room of 4 m × 3 m with a wall in the middle, which leaves a door 1 m wide."""
    x, y = np.arange(0.0, 4.0, 0.04), np.arange(0.0, 3.0, 0.04)
    z = np.arange(0.02, 2.5, 0.08)
    parts = [_plane(x, y, height) for height, wanted in ((0.0, floor), (2.5, ceiling)) if wanted]
    for edge in (0.0, 3.0):
        parts.append(np.stack(np.meshgrid(x, [edge], z), axis=-1).reshape(-1, 3))
    for edge, along in ((0.0, y), (4.0, y), (2.0, y[y < 2.0])):
        parts.append(np.stack(np.meshgrid([edge], along, z), axis=-1).reshape(-1, 3))
    return np.concatenate(parts) + np.array((0.02, 0.02, FLOOR))


def hill_points() -> Points:
    """Return points each 20 cm of a slope of 10 % with a wall 2 m high across it, and a tree."""
    x, y = np.arange(0.0, 30.0, 0.2), np.arange(0.0, 20.0, 0.2)
    ground = _plane(x, y, 0.0)
    wall = np.stack(np.meshgrid([15.0], y[y < 12.0], np.arange(0.1, 2.0, 0.2)), axis=-1).reshape(-1, 3)
    crown = _plane(x[(x > 5) & (x < 9)], y[(y > 5) & (y < 9)], 4.0)
    points = np.concatenate((ground, wall, crown))
    points[:, 2] += 0.1 * points[:, 0]
    return points


def _plane(x: NDArray[np.float64], y: NDArray[np.float64], height: float) -> Points:
    return np.stack(np.meshgrid(x, y, [height]), axis=-1).reshape(-1, 3)
