"""Costmap: one byte per cell, with the values of costmap_2d, also as the occupancy grid that costmap_2d publishes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.errors import InvalidMap
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

if TYPE_CHECKING:
    from ppaas.costmap.causes import Cause


__all__ = [
    "FREE_SPACE",
    "INSCRIBED_INFLATED_OBSTACLE",
    "LETHAL_OBSTACLE",
    "NO_INFORMATION",
    "CausesAt",
    "Changes",
    "Costmap",
    "Indexes",
    "Window",
]

Indexes = Callable[[str, Callable[[], None]], memoryview | None]
"""Called with a planner's name and a function to call at least every 10 ms while waiting; returns its index, if any."""

CausesAt = Callable[[float, float], "Cause | None"]
"""Called with a place x, y in the frame of the map [m]; returns what makes it lethal."""

Window = tuple[slice, slice]
"""Rows and columns of a part of a grid."""


class Changes(NamedTuple):
    """Parts of a costmap that may differ from the map alone. Planners compare only these parts.

    Parameters
    ----------
    base : (height, width) uint8 array
        Costs of the map alone, read-only.
    windows : tuple of Window
        All cells outside these parts equal ``base``.
    """

    base: NDArray[np.uint8]
    windows: tuple[Window, ...]


@dataclass(frozen=True, slots=True)
class Costmap:
    """Cost of each cell for the centre of the robot.

    Parameters
    ----------
    data : (height, width) uint8 array
        0 free, 1–252 graded, 253 inscribed, 254 lethal, 255 unknown; row 0 is the lowest. Planners only read it.
    info : GridInfo
        Geometry of the grid.
    indexes : Indexes, optional
        Returns the index that a planner has prepared of the map, if there is one. The check that it is called with may
        raise, for example when planning is cancelled.
    causes : callable, optional
        Returns what makes a place lethal, for texts.
    changes : Changes, optional
        What differs from the read-only costs that ``data`` is a copy of; None if that is not known.

    Raises
    ------
    InvalidMap
        The array has another shape or type.
    """

    data: NDArray[np.uint8]
    info: GridInfo
    indexes: Indexes | None = None
    causes: CausesAt | None = None
    changes: Changes | None = None

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 cells of shape {self.info.shape}, not {self.data.dtype} of shape {self.data.shape}"
            )

    def costs_at(self, points: ArrayLike, outside: int = NO_INFORMATION) -> NDArray[np.uint8]:
        """Return the costs at points (n, 2) in the frame of the map [m], and ``outside`` where there is no cell."""
        cells = self.info.to_cells(points)
        inside = ((cells >= 0) & (cells < self.info.shape)).all(axis=1)
        costs = np.full(len(cells), outside, np.uint8)
        costs[inside] = self.data[tuple(cells[inside].T)]
        return costs

    def read_only(self) -> Self:
        """Return the costmap itself if it is read-only, otherwise a read-only view without the map's indexes."""
        if not self.data.flags.writeable:
            return self
        data = self.data.view()
        data.flags.writeable = False
        return replace(self, data=data, indexes=None, changes=None)

    def window_around(self, cells: NDArray[np.integer], margin: int) -> Window:
        """Return the smallest window with (n, 2) cells, row and column, and a margin [cells] within the map."""
        top, left = np.maximum(cells.min(axis=0) - margin, 0)
        bottom, right = np.minimum(cells.max(axis=0) + margin + 1, self.info.shape)
        return slice(int(top), int(bottom)), slice(int(left), int(right))

    def copied(self, *windows: Window) -> Self:
        """Return a copy whose cells may be written in these windows, and nowhere else."""
        changes = self.changes or (None if self.data.flags.writeable else Changes(self.data, ()))
        if changes is not None:
            changes = changes._replace(windows=(*changes.windows, *windows))
        return replace(self, data=self.data.copy(), changes=changes)


# -- occupancy grids, as `Costmap2DPublisher` of costmap_2d and nav2_costmap_2d makes them -----------------------------

MAX_CELLS = 1 << 20
"""Largest grid that `occupancy_of` returns; as JSON it has at most 4 MiB [cells]."""

_OCCUPANCY = np.empty(256, np.int8)
_OCCUPANCY[1:INSCRIBED_INFLATED_OBSTACLE] = 1 + 97 * np.arange(INSCRIBED_INFLATED_OBSTACLE - 1) // 251
_OCCUPANCY[FREE_SPACE] = FREE
_OCCUPANCY[INSCRIBED_INFLATED_OBSTACLE] = OCCUPIED - 1
_OCCUPANCY[LETHAL_OBSTACLE] = OCCUPIED
_OCCUPANCY[NO_INFORMATION] = UNKNOWN


def occupancy_of(costmap: Costmap, most: int = MAX_CELLS) -> GridMap:
    """Return a costmap as an occupancy grid: 0 free, 1 to 98 graded, 99 inscribed, 100 lethal, −1 unknown.

    A costmap of more than ``most`` cells becomes coarser: each cell then has the highest value of the k × k cells that
    it covers, with the smallest k that suffices. So it is unknown only if all of them are.
    """
    cells, info = _OCCUPANCY[costmap.data], costmap.info
    coarser = 1
    while -(-info.height // coarser) * -(-info.width // coarser) > most:
        coarser += 1
    if coarser == 1:
        return GridMap(cells, info)
    rows = np.maximum.reduceat(cells, np.arange(0, info.height, coarser), axis=0)
    cells = np.maximum.reduceat(rows, np.arange(0, info.width, coarser), axis=1)
    height, width = cells.shape
    return GridMap(cells, GridInfo(info.resolution * coarser, width, height, info.origin))
