"""Maps with randomly scattered occupied cells."""

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap


def distances(seed: int, info: GridInfo) -> NDArray[np.float32]:
    """Return the distance of each cell from the nearest of randomly scattered occupied cells [m]."""
    data = np.where(np.random.default_rng(seed).random(info.shape) < 0.05, OCCUPIED, FREE).astype(np.int8)
    data[0, 0] = OCCUPIED
    return distance_to_occupied(GridMap(data, info))
