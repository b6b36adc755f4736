"""Comparison of two grids, which are read block by block."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_files import GridRows
from ppaas.maps.grid import UNKNOWN, GridInfo

_ALIGNED = 1e-3
"""Largest distance between the corners of corresponding cells of two aligned grids [cells]."""


class Rectangle(NamedTuple):
    """Rectangle of cells from (column, row) on, which are negative where the older grid reaches further."""

    column: int
    row: int
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Difference:
    """Difference between an older and a newer grid.

    Parameters
    ----------
    changed : int
        Number of changed cells.
    rectangle : Rectangle or None
        Bounding box of the changed cells, in cells of the newer grid; None if nothing changed.
    corners : (4, 2) array or None
        Corners of the bounding box, x, y [m] in the map frame, counter-clockwise from (column, row).
    aligned : bool
        Whether the cells of both grids coincide. If not, the whole newer grid counts as changed.
    """

    changed: int
    rectangle: Rectangle | None
    corners: NDArray[np.float64] | None
    aligned: bool


def difference(old: GridRows, new: GridRows) -> Difference:
    """Return the difference between two grids; cells outside a grid count as unknown.

    Raises
    ------
    InvalidMap
        One of the images has an invalid pixel.
    """
    offset = _offset(old.info, new.info)
    if offset is None:
        whole = Rectangle(0, 0, new.info.width, new.info.height)
        return Difference(whole.width * whole.height, whole, _corners(new.info, whole), aligned=False)
    column, row = offset
    found = _ChangedCells()
    for first, cells in new.blocks():
        found.add(cells != _part(old, (-column, -row), first, cells.shape), first, 0)
    for first, cells in old.blocks():
        found.add(_outside(new.info, offset, first, cells), first + row, column)
    rectangle = found.rectangle()
    corners = None if rectangle is None else _corners(new.info, rectangle)
    return Difference(found.changed, rectangle, corners, aligned=True)


def old_rows(old: GridRows, new: GridInfo, first: int, last: int) -> NDArray[np.int8]:
    """Return the cells of an older grid at the rows ``first`` to ``last`` (excluded) of a newer one, unknown outside.

    Raises
    ------
    InvalidMap
        The image has an invalid pixel, or the cells of the two grids do not coincide.
    """
    offset = _offset(old.info, new)
    if offset is None:
        raise InvalidMap("the cells of the two grids cannot be compared: their resolutions or origins differ")
    column, row = offset
    return _part(old, (-column, -row), first, (last - first, new.width))


def _offset(old: GridInfo, new: GridInfo) -> tuple[int, int] | None:
    """Return the column and row of the new grid at which the old one begins; None if their cells do not coincide."""
    longest = max(old.width, old.height, new.width, new.height)
    turned = math.remainder(old.origin.theta - new.origin.theta, math.tau)
    if max(abs(old.resolution / new.resolution - 1.0), abs(turned)) * longest > _ALIGNED:
        return None
    dx, dy = old.origin.x - new.origin.x, old.origin.y - new.origin.y
    c, s = math.cos(new.origin.theta), math.sin(new.origin.theta)
    column, row = (c * dx + s * dy) / new.resolution, (c * dy - s * dx) / new.resolution
    if not max(abs(column), abs(row)) < 1 << 53:
        return None
    if max(abs(column - round(column)), abs(row - round(row))) > _ALIGNED:
        return None
    return round(column), round(row)


def _part(grid: GridRows, offset: tuple[int, int], first: int, shape: tuple[int, ...]) -> NDArray[np.int8]:
    """Return a grid's cells in a window of another grid, which begins there at column 0 and row ``first``."""
    column, row = offset
    height, width = shape
    cells = np.full(shape, UNKNOWN, np.int8)
    begin, end = max(first + row, 0), min(first + row + height, grid.info.height)
    left, right = max(column, 0), min(column + width, grid.info.width)
    if begin < end and left < right:
        at = begin - row - first
        cells[at : at + end - begin, left - column : right - column] = grid.rows(begin, end)[:, left:right]
    return cells


def _outside(other: GridInfo, offset: tuple[int, int], first: int, cells: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Return a mask of the cells of the rows from ``first`` on that are known and outside another grid."""
    column, row = offset
    known: NDArray[np.bool_] = cells != UNKNOWN
    low, high = -row - first, other.height - row - first
    left, right = -column, other.width - column
    known[max(low, 0) : max(high, 0), max(left, 0) : max(right, 0)] = False
    return known


class _ChangedCells:
    """Number and bounding box of the changed cells found so far."""

    def __init__(self) -> None:
        self.changed = 0
        self._columns: list[int] = []
        self._rows: list[int] = []

    def add(self, differs: NDArray[np.bool_], first: int, left: int) -> None:
        """Add rows of changed cells; the first row is ``first``, and the first column ``left``."""
        count = int(np.count_nonzero(differs))
        if not count:
            return
        self.changed += count
        for bounds, start, axis in ((self._columns, left, 0), (self._rows, first, 1)):
            where = np.flatnonzero(differs.any(axis=axis))
            bounds += [start + int(where[0]), start + int(where[-1])]

    def rectangle(self) -> Rectangle | None:
        """Return the bounding box of all changed cells; None if there are none."""
        if not self.changed:
            return None
        column, row = min(self._columns), min(self._rows)
        return Rectangle(column, row, max(self._columns) - column + 1, max(self._rows) - row + 1)


def _corners(info: GridInfo, rectangle: Rectangle) -> NDArray[np.float64]:
    column, row, width, height = rectangle
    cells = [(row, column), (row, column + width), (row + height, column + width), (row + height, column)]
    return info.to_world(np.subtract(cells, 0.5))
