"""Comparison of two grids, which are read block by block."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps import cell_rectangle
from ppaas.maps.formats.map_files import GridRows
from ppaas.maps.grid import OCCUPIED_THRESHOLD, UNKNOWN, GridInfo

SQUARE = 64
"""Edge of the squares of which rectangles around changed cells are made [cells]."""

MOST_RECTANGLES = 16
"""Largest number of rectangles of a difference."""


class OffsetRectangle(NamedTuple):
    """Rectangle of cells from (column, row) on, which are negative where the older grid reaches further."""

    column: int
    row: int
    width: int
    height: int


@dataclass(slots=True)
class CellCounts:
    """Numbers of cells that became occupied, free, known (from unknown) and unknown."""

    occupied: int = 0
    free: int = 0
    known: int = 0
    unknown: int = 0

    def add(self, old: NDArray[np.int8], new: NDArray[np.int8]) -> None:
        """Count the cells of two equal windows."""
        was, now = _kinds(old), _kinds(new)
        differs = was != now
        self.occupied += int(np.count_nonzero(differs & (now == _OCCUPIED)))
        self.free += int(np.count_nonzero(differs & (now == _FREE)))
        self.known += int(np.count_nonzero(differs & (was == _UNKNOWN)))
        self.unknown += int(np.count_nonzero(differs & (now == _UNKNOWN)))


_FREE, _OCCUPIED, _UNKNOWN = 0, 1, 2


def _kinds(cells: NDArray[np.int8]) -> NDArray[np.int8]:
    kinds: NDArray[np.int8] = (cells >= OCCUPIED_THRESHOLD).astype(np.int8)
    kinds[cells == UNKNOWN] = _UNKNOWN
    return kinds


@dataclass(frozen=True, slots=True)
class Difference:
    """Difference between an older and a newer grid.

    Parameters
    ----------
    changed : int
        Number of changed cells.
    rectangle : OffsetRectangle or None
        Bounding box of the changed cells, in cells of the newer grid; None if nothing changed.
    corners : (4, 2) array or None
        Corners of the bounding box, x, y [m] in the map frame, counter-clockwise from (column, row).
    aligned : bool
        Whether the cells of both grids coincide. If not, the whole newer grid counts as changed.
    counts : CellCounts
        Kinds of the changes.
    rectangles : list of OffsetRectangle
        Up to `MOST_RECTANGLES` rectangles, in cells of the newer grid, which cover all changed cells.
    """

    changed: int
    rectangle: OffsetRectangle | None
    corners: NDArray[np.float64] | None
    aligned: bool
    counts: CellCounts = field(default_factory=CellCounts)
    rectangles: list[OffsetRectangle] = field(default_factory=list)


def difference(old: GridRows, new: GridRows) -> Difference:
    """Return the difference between two grids; cells outside a grid count as unknown.

    Raises
    ------
    InvalidMap
        One of the images has an invalid pixel.
    """
    offset = old.info.shift_to(new.info)
    if offset is None:
        whole = OffsetRectangle(0, 0, new.info.width, new.info.height)
        counts = CellCounts()
        for _, cells in new.blocks():
            counts.add(np.full_like(cells, UNKNOWN), cells)
        return Difference(
            whole.width * whole.height, whole, _corners(new.info, whole), aligned=False, counts=counts,
            rectangles=[whole],
        )  # fmt: skip
    row, column = offset
    found, counts = _ChangedCells(), CellCounts()
    for first, cells in new.blocks():
        before = _part(old, (-column, -row), first, cells.shape)
        differs = cells != before
        if differs.any():
            found.add(differs, first, 0)
            counts.add(before, cells)
    for first, cells in old.blocks():
        outside = _outside(new.info, (column, row), first, cells)
        found.add(outside, first + row, column)
        counts.unknown += int(np.count_nonzero(outside))
    rectangle = found.rectangle()
    corners = None if rectangle is None else _corners(new.info, rectangle)
    return Difference(
        found.changed, rectangle, corners, aligned=True, counts=counts, rectangles=found.rectangles()
    )  # fmt: skip


def old_rows(old: GridRows, new: GridInfo, first: int, last: int) -> NDArray[np.int8]:
    """Return the cells of an older grid at the rows ``first`` to ``last`` (excluded) of a newer one, unknown outside.

    Raises
    ------
    InvalidMap
        The image has an invalid pixel, or the cells of the two grids do not coincide.
    """
    offset = old.info.shift_to(new)
    if offset is None:
        raise InvalidMap("the cells of the two grids cannot be compared: their resolutions or origins differ")
    row, column = offset
    return _part(old, (-column, -row), first, (last - first, new.width))


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
    """Number, bounding box and squares of the changed cells found so far."""

    def __init__(self) -> None:
        self.changed = 0
        self._squares: set[tuple[int, int]] = set()
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
        rows, columns = np.nonzero(differs)
        squares = np.unique(np.stack(((rows + first) // SQUARE, (columns + left) // SQUARE)), axis=1)
        self._squares.update(zip(*squares.tolist(), strict=True))

    def rectangle(self) -> OffsetRectangle | None:
        """Return the bounding box of all changed cells; None if there are none."""
        if not self.changed:
            return None
        column, row = min(self._columns), min(self._rows)
        return OffsetRectangle(column, row, max(self._columns) - column + 1, max(self._rows) - row + 1)

    def rectangles(self) -> list[OffsetRectangle]:
        """Return rectangles that cover the changed cells: of small squares if they are few, else of larger ones."""
        around = self.rectangle()
        squares, side = self._squares, SQUARE
        while around is not None and len(found := _joined(squares, side)) > MOST_RECTANGLES:
            squares, side = {(row // 2, column // 2) for row, column in squares}, 2 * side
        return [] if around is None else [_clipped(one, around) for one in found]


def _joined(squares: set[tuple[int, int]], side: int) -> list[OffsetRectangle]:
    """Return the squares of a grid joined to runs of a row, and equal runs of neighbouring rows to rectangles."""
    runs: list[cell_rectangle.Rectangle] = []
    for row, column in sorted(squares):
        if runs and (runs[-1].row, runs[-1].end_column) == (row, column):
            runs[-1] = runs[-1]._replace(end_column=column + 1)
        else:
            runs.append(cell_rectangle.Rectangle(row, column, row + 1, column + 1))
    return [
        OffsetRectangle(one.column * side, one.row * side, one.shape[1] * side, one.shape[0] * side)
        for one in cell_rectangle.stacked(runs)
    ]


def _clipped(one: OffsetRectangle, around: OffsetRectangle) -> OffsetRectangle:
    column, row = max(one.column, around.column), max(one.row, around.row)
    right = min(one.column + one.width, around.column + around.width)
    top = min(one.row + one.height, around.row + around.height)
    return OffsetRectangle(column, row, right - column, top - row)


def _corners(info: GridInfo, rectangle: OffsetRectangle) -> NDArray[np.float64]:
    column, row, width, height = rectangle
    cells = [(row, column), (row, column + width), (row + height, column + width), (row + height, column)]
    return info.to_world(np.subtract(cells, 0.5))
