"""Occupancy grids and their geometry in the map frame."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D, wrap_angle

FREE = 0
OCCUPIED = 100
UNKNOWN = -1

OCCUPIED_THRESHOLD = 65
"""Least occupancy of an obstacle, map_server's default ``occupied_thresh`` in percent."""

MAX_CELLS = 1 << 30
ORIGIN = Pose2D(0.0, 0.0, 0.0)

SAME_CELL = 1e-3
"""Largest distance between the corners of corresponding cells of two grids whose cells coincide [cells]."""


@dataclass(frozen=True, slots=True)
class GridInfo:
    """Geometry of a grid: ``nav_msgs/MapMetaData`` without its load time.

    Parameters
    ----------
    resolution : float
        Edge of a cell [m].
    width, height : int
        Numbers of cells along x and along y.
    origin : Pose2D
        Pose of the lower-left corner of cell (0, 0) in the map frame.

    Raises
    ------
    InvalidMap
        The resolution is not positive, the grid has no cells or too many, or the origin is not finite.
    """

    resolution: float
    width: int
    height: int
    origin: Pose2D = ORIGIN

    def __post_init__(self) -> None:
        if not (math.isfinite(self.resolution) and self.resolution > 0.0):
            raise InvalidMap(f"resolution must be a positive number of metres, not {self.resolution}")
        if self.width < 1 or self.height < 1 or self.width * self.height > MAX_CELLS:
            raise InvalidMap(f"a grid must have from 1 to {MAX_CELLS} cells, not {self.width}×{self.height}")
        if not self.origin.is_finite():
            raise InvalidMap(f"origin must be finite, not {tuple(self.origin)}")

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the arrays, (height, width); row 0 is the lowest."""
        return self.height, self.width

    def to_cells(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the cells that contain points.

        Parameters
        ----------
        points : (..., 2) array
            x, y [m] in the map frame.

        Returns
        -------
        (..., 2) int array
            Row, column; outside the grid if the point is.
        """
        local = np.asarray(points, dtype=np.float64) - (self.origin.x, self.origin.y)
        c, s = math.cos(self.origin.theta), math.sin(self.origin.theta)
        column = (c * local[..., 0] + s * local[..., 1]) / self.resolution
        row = (-s * local[..., 0] + c * local[..., 1]) / self.resolution
        return np.floor(np.stack((row, column), axis=-1)).astype(np.int64)

    def to_world(self, cells: ArrayLike) -> NDArray[np.float64]:
        """Return the centres of cells in the map frame: (..., 2) x, y [m] from (..., 2) row, column."""
        centre = (np.asarray(cells, dtype=np.float64) + 0.5) * self.resolution
        c, s = math.cos(self.origin.theta), math.sin(self.origin.theta)
        x = c * centre[..., 1] - s * centre[..., 0] + self.origin.x
        y = s * centre[..., 1] + c * centre[..., 0] + self.origin.y
        return np.stack((x, y), axis=-1)

    def cell_of(self, x: float, y: float) -> tuple[int, int] | None:
        """Return (row, column) of one point, or None if it is outside the grid or not finite."""
        # The same as `to_cells`, but ten times as fast for a single point as numpy.
        x, y = x - self.origin.x, y - self.origin.y
        c, s = math.cos(self.origin.theta), math.sin(self.origin.theta)
        row, column = (c * y - s * x) / self.resolution, (c * x + s * y) / self.resolution
        inside = 0.0 <= row < self.height and 0.0 <= column < self.width
        return (int(row), int(column)) if inside else None

    def shift_to(self, other: "GridInfo") -> tuple[int, int] | None:
        """Return how many rows and columns to add to a cell of this grid to get the same cell of another grid.

        None if the cells of both grids do not coincide: their resolutions or angles differ, or they are displaced by a
        part of a cell.
        """
        turned = abs(wrap_angle(self.origin.theta - other.origin.theta))
        if max(abs(self.resolution / other.resolution - 1.0), turned) * max(*self.shape, *other.shape) > SAME_CELL:
            return None
        dx, dy = self.origin.x - other.origin.x, self.origin.y - other.origin.y
        c, s = math.cos(other.origin.theta), math.sin(other.origin.theta)
        row, column = (c * dy - s * dx) / other.resolution, (c * dx + s * dy) / other.resolution
        if not max(abs(row), abs(column)) < 1 << 53:  # larger floats have no fractions to compare
            return None
        if max(abs(row - round(row)), abs(column - round(column))) > SAME_CELL:
            return None
        return round(row), round(column)


@dataclass(frozen=True, slots=True)
class GridMap:
    """Occupancy grid.

    Parameters
    ----------
    data : (height, width) int8 array
        0 free to 100 occupied, −1 unknown; row 0 is the lowest (as in ``nav_msgs/OccupancyGrid``). Never modified.
    info : GridInfo
        Geometry of the grid.

    Raises
    ------
    InvalidMap
        The array has another shape or type.
    """

    data: NDArray[np.int8]
    info: GridInfo

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.int8:
            raise InvalidMap(
                f"expected int8 cells of shape {self.info.shape}, not {self.data.dtype} of shape {self.data.shape}"
            )

    def rows(self, first: int, last: int) -> NDArray[np.int8]:
        """Return the cells of the rows ``first`` to ``last`` (excluded), counted from the lowest row of the map."""
        return self.data[first:last]
