"""Grids of the floors of a building: from walls, and with open doors and cars of lifts."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ppaas.imports.graphs.model.route_graph import GraphMark, Place
from ppaas.imports.maps.common.imported_map import grid_around
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

WALL = 0.1
"""Thickness of walls that are lines [m]."""

OPENING = 0.3
"""Width of the strip along a door in which nothing stands [m]."""

MARGIN = 1.0
"""Width of the border around walls and lanes [m]."""

USUAL_CELLS = 1 << 24
"""Number of cells above which a grid of walls gets larger cells."""


_SHIFT = 1
"""Difference between the greys of a picture and the values of cells, which are -1 and more."""


@dataclass(frozen=True, slots=True)
class FloorShape:
    """Walls and areas of a floor, in the frame of its map [m].

    Parameters
    ----------
    walls : list of pair of Place
    areas, holes : list of list of Place
        Outlines of the floor, and of what is cut out of it.
    places : list of Place
        Other places that the grid is to have, such as ends of lanes.
    """

    walls: list[tuple[Place, Place]] = field(default_factory=list)
    areas: list[list[Place]] = field(default_factory=list)
    holes: list[list[Place]] = field(default_factory=list)
    places: list[Place] = field(default_factory=list)

    def corners(self) -> NDArray[np.float64]:
        """Return all places of the floor, (n, 2)."""
        found = [*self.places, *(end for wall in self.walls for end in wall)]
        found += [place for ring in self.areas for place in ring]
        return np.array(found, np.float64).reshape(-1, 2)


def grid_of_walls(shape: FloorShape, resolution: float, report: ImportReport) -> GridMap:
    """Return the grid of a floor; without areas, all that is no wall is free.

    Raises
    ------
    InvalidMap
        It would have too many cells.
    """
    corners = shape.corners()
    low, high = corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN
    edge = resolution
    while math.prod(((high - low) / edge).tolist()) > USUAL_CELLS:
        edge *= 2.0
    if edge != resolution:
        report.translated("resolution", f"a cell is {edge:g} m, since the floor is large")
    info = grid_around(low, high, edge)
    canvas = _Canvas(info, np.full(info.shape, UNKNOWN if shape.areas else FREE, np.int8))
    for ring in shape.areas:
        canvas.fill(ring, FREE)
    for ring in shape.holes:
        canvas.fill(ring, UNKNOWN)
    for wall in shape.walls:
        canvas.line(wall, WALL, OCCUPIED)
    what = f"{len(shape.areas)} areas" if shape.areas else "all cells that are no walls are free"
    report.translated("walls", f"{len(shape.walls)} walls; {what}")
    return canvas.grid()


def with_marks(grid: GridMap, marks: Sequence[GraphMark]) -> GridMap:
    """Return a grid in which doors are open, and cars of lifts are free and have walls around them."""
    canvas = _Canvas(grid.info, grid.data.copy())
    edge = grid.info.resolution
    cars = [mark.places for mark in marks if mark.kind == "lift"]
    for car in cars:
        canvas.fill(_around(car, WALL + edge), OCCUPIED)
    for car in cars:
        canvas.fill(car, FREE)
    for mark in marks:
        if mark.kind == "door":
            canvas.line(mark.places, OPENING + 2.0 * edge, FREE)
    return canvas.grid()


def _around(corners: Sequence[Place], width: float) -> list[Place]:
    """Return an outline with a border of a width around it."""
    import shapely  # noqa: PLC0415 - only imports of buildings need it

    wider = shapely.Polygon(corners).buffer(width, join_style="mitre")
    return [(x, y) for x, y in shapely.get_coordinates(wider.exterior).tolist()]


class _Canvas:
    """Cells to draw on: row 0 is the lowest, as in grids."""

    def __init__(self, info: GridInfo, data: NDArray[np.int8]) -> None:
        self._info = info
        self._picture = Image.fromarray((data + _SHIFT).astype(np.uint8))
        self._brush = ImageDraw.Draw(self._picture)

    def grid(self) -> GridMap:
        return GridMap((np.asarray(self._picture, np.int16) - _SHIFT).astype(np.int8), self._info)

    def fill(self, ring: Iterable[Place], value: int) -> None:
        self._brush.polygon(self._pixels(ring), fill=value + _SHIFT)

    def line(self, places: Iterable[Place], width: float, value: int) -> None:
        cells = max(1, round(width / self._info.resolution))
        self._brush.line(self._pixels(places), fill=value + _SHIFT, width=cells)

    def _pixels(self, places: Iterable[Place]) -> list[tuple[int, int]]:
        cells = self._info.to_cells(list(places))
        return [(column, row) for row, column in cells.tolist()]
