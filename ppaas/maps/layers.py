"""What is derived from a map once per version and robot radius, and shared by all who stand in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridMap


@dataclass(frozen=True, slots=True)
class MapLayers:
    """A map and what is derived from it; read-only, memory-mapped where a machine shares it.

    Parameters
    ----------
    grid : GridMap
        The map itself.
    costmap : Costmap
        Static layer, inflated for the robot's radius.
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied one [m]; localization's likelihood field is read off it.
    """

    grid: GridMap
    costmap: Costmap
    distance: NDArray[np.float32]
