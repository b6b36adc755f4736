"""Small maps for simulated robots."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap


def room(width: float, height: float, resolution: float = 0.05, origin: Pose2D = Pose2D(0.0, 0.0)) -> GridMap:
    """Return an empty room with walls one cell thick."""
    info = GridInfo(resolution, round(width / resolution), round(height / resolution), origin)
    cells = np.full(info.shape, FREE, np.int8)
    cells[[0, -1]] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return GridMap(cells, info)
