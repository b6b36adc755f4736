"""Reference of the layers of a map: the static layer of costmap_2d, before inflation."""

import numpy as np

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import OCCUPIED_THRESHOLD, UNKNOWN, GridMap


def static_costmap(grid: GridMap) -> Costmap:
    """Return the costmap of a map before inflation: lethal, unknown and free cells.

    Cells of 65 or more are lethal, as those that map_server makes 100 are in costmap_2d with its default
    ``lethal_cost_threshold`` and ``trinary_costmap``; graded cells below are free.
    """
    costs = np.full(grid.info.shape, FREE_SPACE, np.uint8)
    costs[grid.data >= OCCUPIED_THRESHOLD] = LETHAL_OBSTACLE
    costs[grid.data == UNKNOWN] = NO_INFORMATION
    return Costmap(costs, grid.info)
