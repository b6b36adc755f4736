"""The costmap: one byte a cell, with the values of costmap_2d."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.errors import InvalidMap
from ppaas.maps.grid import GridInfo

__all__ = [
    "FREE_SPACE",
    "INSCRIBED_INFLATED_OBSTACLE",
    "LETHAL_OBSTACLE",
    "NO_INFORMATION",
    "Costmap",
    "Indexes",
]

Indexes = Callable[[str, Callable[[], None]], memoryview | None]


@dataclass(frozen=True, slots=True)
class Costmap:
    """What each cell costs the centre of the robot.

    Parameters
    ----------
    data : (height, width) uint8 array
        0 free, 1–252 graded, 253 inscribed, 254 lethal, 255 unknown; row 0 is the lowest. Planners only read it.
    info : GridInfo
        Where it lies.
    indexes : callable, optional
        Gives what others have prepared of the map in which this was seen, if they have: by the name of the planner
        that asks, and a check that it calls at least every 10 ms while it waits.
    """

    data: NDArray[np.uint8]
    info: GridInfo
    indexes: Indexes | None = None

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 cells of shape {self.info.shape}, got {self.data.dtype} of {self.data.shape}"
            )
