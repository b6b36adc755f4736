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
        Static layer, inflated for the robot's radius; what is kept out of counts as occupied.
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied one [m]; localization's likelihood field is read off it.
    keepout : GridMap, optional
        Where robots are to keep out, by the cells of the map: 100 altogether, 1 to 99 the more the higher.
    barred_distance : (height, width) float32 array, optional
        With ``keepout``: as ``distance``, but to the nearest cell that is occupied or 100 in ``keepout`` [m].
    speed : GridMap, optional
        Mask of the speed filter, by the cells of the map.
    """

    grid: GridMap
    costmap: Costmap
    distance: NDArray[np.float32]
    keepout: GridMap | None = None
    barred_distance: NDArray[np.float32] | None = None
    speed: GridMap | None = None

    @property
    def to_lethal(self) -> NDArray[np.float32]:
        """(height, width): distance to the nearest cell that no robot may touch [m]."""
        return self.distance if self.barred_distance is None else self.barred_distance
