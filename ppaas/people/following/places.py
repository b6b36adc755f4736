"""Places of a map: where a robot can stand, where people can walk, and what is in sight."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, GridInfo
from ppaas.maps.raycast import cast_rays

MOST_COST = 128
"""Cost of a place from which an obstacle is about 7 cm farther than it must be; Move Base sees obstacles a little
larger than they are on the map."""


class Places:
    """Questions about the map of a robot. Only the neighbourhood of a point is read.

    Parameters
    ----------
    layers : MapLayers
        The map, inflated for the robot.
    """

    def __init__(self, layers: MapLayers) -> None:
        self._layers = layers

    def standable(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether the robot can stand at each of (n, 2) points x, y [m]."""
        costmap = self._layers.costmap
        cells = costmap.info.to_cells(points)
        inside = ((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)
        free = np.zeros(len(cells), np.bool_)
        rows, columns = cells[inside].T
        free[inside] = costmap.data[rows, columns] < MOST_COST
        return free

    def sight(self, origin: Pose2D, angles: ArrayLike, most: float) -> NDArray[np.float64]:
        """Return how far one sees from a pose in directions relative to its heading [rad], up to ``most`` [m]."""
        window = self._window(origin.x, origin.y, most)
        if window is None:
            return np.full(np.shape(angles), most)
        cells, info = window
        return np.minimum(cast_rays(cells >= OCCUPIED_THRESHOLD, info, origin, angles, most), most)

    def sees(self, one: tuple[float, float], other: tuple[float, float]) -> bool:
        """Return whether no wall is between two points x, y [m]."""
        apart = math.dist(one, other)
        heading = math.atan2(other[1] - one[1], other[0] - one[0])
        return bool(self.sight(Pose2D(*one, heading), [0.0], apart + 0.05)[0] >= apart)

    def walkable(self, x: float, y: float, reach: float, size: float) -> tuple[NDArray[np.bool_], GridInfo] | None:
        """Return the cells around a point in which people can walk: known cells without an obstacle.

        Parameters
        ----------
        x, y : float
            The point [m].
        reach : float
            Half the edge of the square around it [m].
        size : float
            Least edge of a cell [m], rounded to a number of cells of the map.

        Returns
        -------
        (h, w) array of bool and GridInfo, or None
            None outside the map.
        """
        window = self._window(x, y, reach)
        if window is None:
            return None
        cells, info = window
        factor = max(round(size / info.resolution), 1)
        height, width = (-(-edge // factor) for edge in cells.shape)
        padded = np.zeros((height * factor, width * factor), np.bool_)
        padded[: cells.shape[0], : cells.shape[1]] = (cells >= FREE) & (cells < OCCUPIED_THRESHOLD)
        free = np.logical_and.reduce(padded.reshape(height, factor, width, factor), axis=(1, 3))
        return free, GridInfo(info.resolution * factor, width, height, info.origin)

    def _window(self, x: float, y: float, reach: float) -> tuple[NDArray[np.int8], GridInfo] | None:
        """Return the cells of the map within ``reach`` of a point along its axes, and their geometry."""
        info = self._layers.grid.info
        row, column = info.to_cells((x, y)).tolist()
        margin = math.ceil(reach / info.resolution) + 1
        low = max(row - margin, 0), max(column - margin, 0)
        high = min(row + margin + 1, info.height), min(column + margin + 1, info.width)
        if high[0] <= low[0] or high[1] <= low[1]:
            return None
        corner = info.origin @ Pose2D(low[1] * info.resolution, low[0] * info.resolution)
        size = high[1] - low[1], high[0] - low[0]
        return self._layers.grid.data[low[0] : high[0], low[1] : high[1]], GridInfo(info.resolution, *size, corner)
