"""Uniform sampling of poses in the free cells of a map."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.localization.kernels.free_cells import count_free, find_free
from ppaas.maps.grid import GridMap


class FreePoses:
    """Draws poses uniformly from the free cells of a map.

    Parameters
    ----------
    grid : GridMap
    """

    def __init__(self, grid: GridMap) -> None:
        self._grid = grid
        self._counted: NDArray[np.int64] | None = None

    @property
    def area(self) -> float:
        """Area of all free cells [m²].

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        return float(self._below()[-1]) * self._grid.info.resolution**2

    def draw(self, count: int, random: np.random.Generator) -> NDArray[np.float64]:
        """Return poses (count, 3): x, y [m], theta [rad] in the map frame.

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        below, info = self._below(), self._grid.info
        cells = find_free(self._grid.data, below, np.sort(random.integers(0, int(below[-1]), count)))
        centres = info.to_world(cells + random.random((count, 2)) - 0.5)
        return np.column_stack((centres, random.uniform(-math.pi, math.pi, count)))

    def _below(self) -> NDArray[np.int64]:
        """Return for each row the number of free cells in it and all rows below it, counted at the first call."""
        if self._counted is None:
            self._counted = count_free(self._grid.data)
        if not self._counted[-1]:
            raise InvalidMap("the map has no free cell, so no robot can be in it; publish a map with free cells")
        return self._counted
