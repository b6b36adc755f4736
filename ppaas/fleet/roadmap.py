"""Roadmap: the cells of a map in which a robot of a fleet may stand, and the moves between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput

BLOCKED = -1
"""Number of a cell in which no robot may stand."""


@dataclass(frozen=True, slots=True)
class Roadmap:
    """Cells that are as large as a robot, each with up to four neighbours.

    Parameters
    ----------
    neighbours : (v, 4) int32 array
        Neighbours of each cell, −1 behind the last one. Each is a neighbour of its neighbours.
    cells : (v, 2) int32 array
        Row and column of each cell.
    numbers : (h, w) int32 array
        Number of each cell, `BLOCKED` where no robot may stand.
    """

    neighbours: NDArray[np.int32]
    cells: NDArray[np.int32]
    numbers: NDArray[np.int32]

    @classmethod
    def of_grid(cls, free: NDArray[np.bool_]) -> "Roadmap":
        """Return the roadmap of a grid.

        Parameters
        ----------
        free : (h, w) bool array
            True where a robot may stand.
        """
        rows, columns = np.nonzero(free)
        numbers = np.full(free.shape, BLOCKED, np.int32)
        numbers[rows, columns] = np.arange(len(rows), dtype=np.int32)
        padded = np.pad(numbers, 1, constant_values=BLOCKED)
        beside = ((0, 1), (2, 1), (1, 0), (1, 2))
        near = np.stack([padded[rows + down, columns + right] for down, right in beside], axis=1)
        last = np.argsort(near == BLOCKED, axis=1, kind="stable")
        neighbours = np.ascontiguousarray(np.take_along_axis(near, last, axis=1), np.int32)
        return cls(neighbours, np.stack([rows, columns], axis=1).astype(np.int32), numbers)

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.cells)

    def at(self, places: NDArray[np.int64], what: str) -> NDArray[np.int32]:
        """Return the numbers of cells.

        Parameters
        ----------
        places : (n, 2) int64 array
            Row and column of each.
        what : str
            Name of the places for errors.

        Raises
        ------
        InvalidInput
            A place is outside the map, or no robot may stand there; the text says which.
        """
        height, width = self.numbers.shape
        inside = np.all((places >= 0) & (places < (height, width)), axis=1)
        found = np.full(len(places), BLOCKED, np.int32)
        found[inside] = self.numbers[tuple(places[inside].T)]
        for robot in np.nonzero(found == BLOCKED)[0][:1]:
            row, column = places[robot]
            why = "is blocked" if inside[robot] else f"is outside the map of {height} rows and {width} columns"
            raise InvalidInput(f"the {what} of robot {robot}, row {row} column {column}, {why}")
        return found
