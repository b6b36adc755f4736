"""Rectangles of cells, as slices of the array of a grid, and those that cover the differences of two grids."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Rectangle(NamedTuple):
    """Cells of a grid.

    Parameters
    ----------
    row, column : int
        Lower-left cell.
    end_row, end_column : int
        Row and column after the last.
    """

    row: int
    column: int
    end_row: int
    end_column: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """Slices of the array of the grid."""
        return slice(self.row, self.end_row), slice(self.column, self.end_column)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [cells]."""
        return self.end_row - self.row, self.end_column - self.column

    def around(self, other: "Rectangle") -> "Rectangle":
        """Return the smallest rectangle around this one and another."""
        low, high = map(min, self[:2], other[:2]), map(max, self[2:], other[2:])
        return Rectangle(*low, *high)

    def moved(self, rows: int, columns: int) -> "Rectangle":
        """Return the rectangle moved by some rows and columns."""
        return Rectangle(self.row + rows, self.column + columns, self.end_row + rows, self.end_column + columns)


def stacked(pieces: list[Rectangle]) -> list[Rectangle]:
    """Join rectangles, sorted by row, with the one directly below if it has the same columns."""
    joined: dict[tuple[int, int, int], Rectangle] = {}
    for piece in pieces:
        below = joined.pop((piece.row, piece.column, piece.end_column), None)
        grown = piece if below is None else piece._replace(row=below.row)
        joined[piece.end_row, piece.column, piece.end_column] = grown
    return list(joined.values())


SIDE = 64
"""Edge of the squares that are compared as a whole [cells]."""


def changed_rectangles(before: NDArray[np.int8], after: NDArray[np.int8], within: Rectangle) -> list[Rectangle]:
    """Return rectangles that do not overlap and cover all cells that differ.

    Parameters
    ----------
    before, after : (h, w) int8 array
        Grids of one geometry.
    within : Rectangle
        Cells to compare.
    """
    old, new = before[within.slices], after[within.slices]
    bands = range(0, old.shape[0], SIDE)  # one by one, since a mask of a large map would not fit in the cache
    found = [piece for row in bands for piece in _of_band(old[row : row + SIDE] != new[row : row + SIDE], row)]
    return [_cropped(piece, old, new).moved(within.row, within.column) for piece in stacked(found)]


def _cropped(piece: Rectangle, old: NDArray[np.int8], new: NDArray[np.int8]) -> Rectangle:
    """Return the smallest part of a rectangle that has all its cells that differ."""
    differs = old[piece.slices] != new[piece.slices]
    rows, columns = (np.flatnonzero(np.logical_or.reduce(differs, axis=axis)) for axis in (1, 0))
    inner = Rectangle(int(rows[0]), int(columns[0]), int(rows[-1]) + 1, int(columns[-1]) + 1)
    return inner.moved(piece.row, piece.column)


def _of_band(differs: NDArray[np.bool_], row: int) -> list[Rectangle]:
    if not differs.any():
        return []
    columns: NDArray[np.bool_] = np.logical_or.reduce(differs, axis=0)
    squares = np.add.reduceat(columns, np.arange(0, len(columns), SIDE)) > 0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], squares.astype(np.int8), [0]))))
    end_row, width = row + differs.shape[0], len(columns)
    return [
        Rectangle(row, begin * SIDE, end_row, min(end * SIDE, width))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    ]
