"""Obstacle memory: obstacles that have left the local costmap, for planning across the whole map.

A robot that finds a door closed and turns to another one must remember the first, or it drives to and fro between them.
costmap_2d has a second obstacle layer over the whole map for this; here only the marked cells are stored.
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
"""Distance from the map's obstacles within which a marked cell is taken for that obstacle, given pose errors [m]."""


class ObstacleMemory:
    """Cells of the map in which the laser saw an obstacle that is not in the map.

    A cell is remembered until it is seen free or cleared. Known robots and people are not remembered, since they move.

    Parameters
    ----------
    layers : MapLayers
        Layers of the map.
    robot_radius : float
        Inscribed radius of the robot [m].
    inflation_radius : float
        Distance from obstacles up to which cells have a cost [m].
    cost_scaling_factor : float
        Rate at which costs decay with the distance [1/m].
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
        self._reach = max(robot_radius, inflation_radius)
        self._inflate = partial(
            inflate,
            inscribed_radius=robot_radius,
            inflation_radius=inflation_radius,
            cost_scaling_factor=cost_scaling_factor,
        )
        self._cells: NDArray[np.int64] = np.empty((0, 2), np.int64)

    @property
    def cells(self) -> NDArray[np.int64]:
        """(n, 2) int64 array: row, column of the remembered cells."""
        return self._cells

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map. Cells that the new map does not cover, or in which it has an obstacle too, are forgotten."""
        centres = self._layers.grid.info.to_world(self._cells)
        self._layers = layers
        self._cells = self._new(np.unique(layers.grid.info.to_cells(centres), axis=0), ())

    def update(self, seen: ObstacleLayer, others: Iterable[Disc] = ()) -> None:
        """Add the obstacles in the window of the local costmap, and remove cells that it has seen.

        Parameters
        ----------
        seen : ObstacleLayer
            Obstacle layer of the local costmap.
        others : iterable of (x, y, radius)
            Discs of known robots and people, in the frame of the map [m]; cells in them are not remembered.
        """
        corner = np.array((seen.row, seen.column))
        marked = self._new(np.argwhere(seen.marked) + corner, others)
        kept = self._cells
        if len(kept):
            # Cells outside the window are not refuted: the local costmap has forgotten them.
            inside = self._within(kept - corner, seen.cells.shape)
            refuted = np.zeros(len(kept), np.bool_)
            refuted[inside] = seen.seen[tuple((kept[inside] - corner).T)]
            kept = kept[~refuted]
        self._cells = np.concatenate((kept, marked))

    def overlay(self, costmap: Costmap) -> Costmap:
        """Return a costmap of the whole map with the remembered obstacles; the given costmap is not modified."""
        cells = self._cells
        if not len(cells):
            return costmap
        margin = math.ceil(self._reach / costmap.info.resolution) + 1
        window = costmap.window_around(cells, margin)
        lethal = np.zeros(costmap.data[window].shape, np.uint8)
        lethal[cells[:, 0] - window[0].start, cells[:, 1] - window[1].start] = 1
        costs = self._inflate(distance_serial(lethal, costmap.info.resolution))
        current = costmap.copied(window)
        part = current.data[window]
        # As by the local costmap, unknown cells change only if they are blocked.
        unknown = (part == NO_INFORMATION) & (costs < INSCRIBED_INFLATED_OBSTACLE)
        np.copyto(part, np.where(part == NO_INFORMATION, costs, np.maximum(part, costs)), where=~unknown)
        return current

    def clear(self, around: Pose2D | None = None, beyond: float = 0.0) -> None:
        """Forget all cells, or only those farther than ``beyond`` [m] from a pose in the frame of the map."""
        if around is None or not len(self._cells):
            self._cells = self._cells[:0]
            return
        centres = self._layers.grid.info.to_world(self._cells)
        self._cells = self._cells[np.hypot(centres[:, 0] - around.x, centres[:, 1] - around.y) <= beyond]

    def _new(self, marked: NDArray[np.int64], others: Iterable[Disc]) -> NDArray[np.int64]:
        """Return the marked cells that are neither obstacles of the map nor within the discs of ``others``."""
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
