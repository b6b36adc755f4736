"""Drawn walls of a floor plan, and the scale that two points of it give."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.imports.maps.common.imported_map import check_cells

RESOLUTION = 0.05
"""Edge of a cell of a plan [m]."""

OVERSAMPLING = 3
"""Number of pixels along a cell in which a drawing is rendered: lines thinner than a cell are not lost."""

MOST_PIXELS = 1 << 25
"""Number of pixels beyond which a drawing is rendered in fewer along a cell."""

DARK = 128
"""Grey below which a pixel is a wall, as default."""


@dataclass(frozen=True, slots=True)
class ScaleBar:
    """Two points of a plan with their distance.

    Parameters
    ----------
    begin, end : tuple of float
        x, y in the units of the file, from its upper left corner; those of DXF are its own, with y up.
    metres : float
        Their distance [m].

    Raises
    ------
    InvalidInput
        They are equal, or a number is not finite.
    """

    begin: tuple[float, float]
    end: tuple[float, float]
    metres: float

    def __post_init__(self) -> None:
        numbers = (*self.begin, *self.end, self.metres)
        if not all(map(math.isfinite, numbers)) or self.metres <= 0.0 or self.begin == self.end:
            raise InvalidInput("--scale-by needs two different points and their distance in metres: X1,Y1,X2,Y2,METRES")

    @property
    def unit(self) -> float:
        """Metres of a unit of the file."""
        return self.metres / math.dist(self.begin, self.end)


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """What a person may choose for the import of a floor plan.

    Parameters
    ----------
    scale : ScaleBar, optional
        Scale; a DXF may have units instead.
    resolution : float
        Edge of a cell [m].
    dark : int
        Grey below which a pixel is a wall, from 0 to 255.
    thinnest : float
        Lines thinner than this are no walls [m].
    page : int
        Page of a PDF, from 1.
    layers : tuple of str
        Layers of a DXF that are walls; all that are not known to be other things if empty.
    start : tuple of float, optional
        A free place, x, y in the frame of the map [m].
    outside_is_free : bool
        Whether cells that no walls enclose are free.
    """

    scale: ScaleBar | None = None
    resolution: float = RESOLUTION
    dark: int = DARK
    thinnest: float = 0.0
    page: int = 1
    layers: tuple[str, ...] = ()
    start: tuple[float, float] | None = None
    outside_is_free: bool = False


@dataclass(frozen=True, slots=True)
class DrawnPlan:
    """Plan as pixels.

    Parameters
    ----------
    greys : (height, width) uint8 array
        Row 0 is the top.
    pixel : float
        Edge of a pixel [m].
    corner : tuple of float
        x, y of the lower left corner in the frame of the map [m].
    """

    greys: NDArray[np.uint8]
    pixel: float
    corner: tuple[float, float] = (0.0, 0.0)


def needed_scale(options: PlanOptions) -> ScaleBar:
    """Return the scale of the options; ``InvalidInput`` if there is none."""
    if options.scale is None:
        raise InvalidInput("the plan has no scale: give two points and their distance, --scale-by X1,Y1,X2,Y2,METRES")
    return options.scale


def pixels_of(width: float, height: float, options: PlanOptions) -> tuple[int, int, float]:
    """Return the size in pixels in which a drawing of a size in its units is rendered, and the edge of a pixel [m].

    Raises
    ------
    InvalidMap
        It is too large.
    """
    unit = needed_scale(options).unit
    across, down = width * unit / options.resolution, height * unit / options.resolution
    check_cells(math.ceil(across), math.ceil(down), options.resolution)
    fitting = (each for each in range(OVERSAMPLING, 1, -1) if across * down * each**2 <= MOST_PIXELS)
    along = next(fitting, 1)
    return max(1, round(across * along)), max(1, round(down * along)), options.resolution / along
