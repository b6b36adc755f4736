"""What was seen and lies behind: obstacles that the local costmap has forgotten, for planning across the map.

A robot that finds a door shut and turns to another one must remember the first, or it runs to and fro between them.
costmap_2d keeps a second obstacle layer over the whole map for this; here only the cells that were marked are kept.
"""

import math
from collections.abc import Iterable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR, INFLATION_RADIUS, ROBOT_RADIUS, inflate
from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import Disc
from ppaas.costmap.obstacle_layer import ObstacleLayer
from ppaas.geometry import Pose2D
from ppaas.maps.kernels.distance import distance_serial

WALL_MARGIN = 0.15
"""What was seen this near to an obstacle of the map is that obstacle, seen from a pose that was a little off [m]."""


class ObstacleMemory:
    """Cells of the map in which the laser saw something that the map does not know of.

    A cell is remembered until it is seen free, or cleared. Robots and people that are known to be there by other
    means are not remembered: they move.

    Parameters
    ----------
    layers : MapLayers
        The map.
    robot_radius, inflation_radius : float
        [m].
    cost_scaling_factor : float
        [1/m].
    """

    def __init__(
        self,
        layers: MapLayers,
        *,
        robot_radius: float = ROBOT_RADIUS,
        inflation_radius: float = INFLATION_RADIUS,
        cost_scaling_factor: float = COST_SCALING_FACTOR,
    ) -> None:
        self._layers = layers
        self._margin = math.ceil(max(robot_radius, inflation_radius) / layers.grid.info.resolution) + 1
        self._inflate = partial(
            inflate,
            inscribed_radius=robot_radius,
            inflation_radius=inflation_radius,
            cost_scaling_factor=cost_scaling_factor,
        )
        self._cells: NDArray[np.int64] = np.empty((0, 2), np.int64)

    @property
    def cells(self) -> NDArray[np.int64]:
        """(n, 2) row, column of what is remembered."""
        return self._cells

    def update(self, seen: ObstacleLayer, others: Iterable[Disc] = ()) -> None:
        """Take over what is in the window now.

        Parameters
        ----------
        seen : ObstacleLayer
            Of the local costmap.
        others : iterable of (x, y, radius)
            Who is there and moves, in the frame of the map [m].
        """
        corner = np.array((seen.row, seen.column))
        marked = self._new(np.argwhere(seen.marked) + corner, others)
        kept = self._cells
        if len(kept):
            inside = self._within(kept - corner, seen.cells.shape)
            refuted = np.zeros(len(kept), np.bool_)
            refuted[inside] = seen.seen[tuple((kept[inside] - corner).T)]
            kept = kept[~refuted]
        self._cells = np.concatenate((kept, marked))

    def overlay(self, costmap: Costmap) -> Costmap:
        """Return a costmap of the whole map with what is remembered; what was given is not written to."""
        cells = self._cells
        if not len(cells):
            return costmap
        top, left = np.maximum(cells.min(axis=0) - self._margin, 0)
        bottom, right = np.minimum(cells.max(axis=0) + self._margin + 1, costmap.info.shape)
        lethal = np.zeros((bottom - top, right - left), np.uint8)
        lethal[cells[:, 0] - top, cells[:, 1] - left] = 1
        costs = self._inflate(distance_serial(lethal, costmap.info.resolution))
        data = costmap.data.copy()
        part = data[top:bottom, left:right]
        unknown = (part == NO_INFORMATION) & (costs < INSCRIBED_INFLATED_OBSTACLE)
        np.copyto(part, np.where(part == NO_INFORMATION, costs, np.maximum(part, costs)), where=~unknown)
        return Costmap(data, costmap.info, costmap.indexes)

    def clear(self, around: Pose2D | None = None, beyond: float = 0.0) -> None:
        """Forget everything, or what is farther than ``beyond`` [m] from a pose in the frame of the map."""
        if around is None or not len(self._cells):
            self._cells = self._cells[:0]
            return
        centres = self._layers.grid.info.to_world(self._cells)
        self._cells = self._cells[np.hypot(centres[:, 0] - around.x, centres[:, 1] - around.y) <= beyond]

    def _new(self, marked: NDArray[np.int64], others: Iterable[Disc]) -> NDArray[np.int64]:
        """Return the marked cells that neither the map nor those who move account for."""
        marked = marked[self._within(marked, self._layers.distance.shape)]
        marked = marked[self._layers.distance[tuple(marked.T)] > WALL_MARGIN]
        centres = self._layers.grid.info.to_world(marked)
        for x, y, radius in others:
            still = np.hypot(centres[:, 0] - x, centres[:, 1] - y) > radius
            marked, centres = marked[still], centres[still]
        return marked

    @staticmethod
    def _within(cells: NDArray[np.int64], shape: tuple[int, ...]) -> NDArray[np.bool_]:
        rows, columns = cells.T
        inside: NDArray[np.bool_] = (rows >= 0) & (rows < shape[0]) & (columns >= 0) & (columns < shape[1])
        return inside
