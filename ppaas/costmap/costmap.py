"""Costmap: one byte per cell, with the values of costmap_2d."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.errors import InvalidMap
from ppaas.maps.grid import GridInfo

if TYPE_CHECKING:
    from ppaas.costmap.causes import Cause

__all__ = [
    "FREE_SPACE",
    "INSCRIBED_INFLATED_OBSTACLE",
    "LETHAL_OBSTACLE",
    "NO_INFORMATION",
    "CausesAt",
    "Costmap",
    "Indexes",
]

Indexes = Callable[[str, Callable[[], None]], memoryview | None]
"""Called with a planner's name and a function to call at least every 10 ms while waiting; returns its index, if any."""

CausesAt = Callable[[float, float], "Cause | None"]
"""Called with a place x, y in the frame of the map [m]; returns what makes it lethal."""


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

    Raises
    ------
    InvalidMap
        The array has another shape or type.
    """

    data: NDArray[np.uint8]
    info: GridInfo
    indexes: Indexes | None = None
    causes: CausesAt | None = None

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 cells of shape {self.info.shape}, not {self.data.dtype} of shape {self.data.shape}"
            )
