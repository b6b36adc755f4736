"""Sizes of the robots of a fleet, and the room that they need on a map."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.maps.grid import UNKNOWN

TINY = 1e-9
"""Length that rounding of numbers may make up [m]: a disc that is less deep in a square only reaches its border."""


@dataclass(frozen=True, slots=True)
class RobotSizes:
    """Radii of robots, and their distances from each other and from obstacles.

    Parameters
    ----------
    radius, margin : float
        Radius of the largest robots, and the distance by which all may stray from their paths [m].
    width : float, optional
        Width of a cell [m]: two robots in neighbouring cells must fit. By default a diameter and twice the margin.
    clearance : float, optional
        Least distance of the largest robots' ways from lethal cells [m], by default the radius and the margin; more
        where sensors see walls nearer than the map has them.
    smaller : sequence of float
        Radii of smaller robots [m].

    Raises
    ------
    InvalidInput
        A size is not positive or not finite, or the width is too small.
    """

    radius: float
    margin: float
    width: float | None = None
    clearance: float | None = None
    smaller: Sequence[float] = ()

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise InvalidInput(f"the radius must be a positive number of metres, not {self.radius}")
        if not (math.isfinite(self.margin) and self.margin >= 0.0):
            raise InvalidInput(f"the margin must be at least 0 m and finite, not {self.margin}")
        least = 2.0 * (self.radius + self.margin)
        if not (math.isfinite(self.spacing) and self.spacing >= least - TINY):
            raise InvalidInput(
                f"the spacing must be at least {least:g} m, where robots in neighbouring cells fit: {self.spacing}"
            )

    @property
    def spacing(self) -> float:
        """Width of a cell [m]."""
        return 2.0 * (self.radius + self.margin) if self.width is None else self.width

    @property
    def radii(self) -> tuple[float, ...]:
        """Radius of robots of each size, in ascending order [m]; empty if all are as large."""
        others = sorted({each for each in self.smaller if each < self.radius - TINY})
        return (*others, self.radius) if others else ()

    def room(self, to_lethal: NDArray[np.float32]) -> list[NDArray[np.bool_]]:
        """Return where robots of each size may be, smallest first: (h, w) bool arrays.

        Parameters
        ----------
        to_lethal : (h, w) float32 array
            Distance from each map cell to the nearest lethal cell [m], 0 in unknown cells (`clearance_of`).
        """
        more = max(self.radius + self.margin, self.clearance or 0.0) - self.radius
        return [to_lethal >= np.float32(each + more) for each in self.radii or (self.radius,)]


def clearance_of(layers: MapLayers) -> NDArray[np.float32]:
    """Return the distances of a map's cells to the nearest lethal cell [m], and 0 in unknown cells."""
    return np.where(layers.grid.data == UNKNOWN, np.float32(0.0), layers.to_lethal)
