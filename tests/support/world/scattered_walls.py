"""Maps with a few occupied cells here and there."""

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.distance import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap


def distances(seed: int, info: GridInfo) -> NDArray[np.float32]:
    """Return how far each cell is from the nearest of some occupied cells."""
    data = np.where(np.random.default_rng(seed).random(info.shape) < 0.05, OCCUPIED, FREE).astype(np.int8)
    data[0, 0] = OCCUPIED
    return distance_to_occupied(GridMap(data, info))
