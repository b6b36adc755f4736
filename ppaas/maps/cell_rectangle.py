"""Rectangles of cells, as slices of the array of a grid."""

from typing import NamedTuple


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
