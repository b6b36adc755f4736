"""Roadmap: the cells of a map in which a robot of a fleet may stand, and the moves between them."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

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
        Cells to which a robot may move from each cell, −1 behind the last one.
    incoming : (v, 4) int32 array
        Cells from which a robot may move into each cell, −1 behind the last one; the same as ``neighbours`` where no
        move is one-way.
    cells : (v, 2) int32 array
        Row and column of each cell.
    numbers : (h, w) int32 array
        Number of each cell, `BLOCKED` where no robot may stand.
    areas : (v,) uint64 array
        Areas that each cell is in, as bits: bit a for area a. (0,) without areas.
    room : (a,) int32 array
        Number of robots that may be in each area at a time.
    barred : (s, v) bool array
        True for cells that robots of each size do not enter; (0, 0) if robots of all sizes may enter all cells.
    """

    neighbours: NDArray[np.int32]
    incoming: NDArray[np.int32]
    cells: NDArray[np.int32]
    numbers: NDArray[np.int32]
    areas: NDArray[np.uint64] = field(default_factory=lambda: np.empty(0, np.uint64))
    room: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))
    barred: NDArray[np.bool_] = field(default_factory=lambda: np.empty((0, 0), np.bool_))

    @classmethod
    def of_grid(cls, free: NDArray[np.bool_]) -> "Roadmap":
        """Return the roadmap of a grid.

        Parameters
        ----------
        free : (h, w) bool array
            True where a robot may stand.
        """
        cells, numbers, near = _beside(free)
        both = _packed(near)
        return cls(both, both, cells, numbers)

    @classmethod
    def of_moves(cls, free: NDArray[np.bool_], in_rows: NDArray[np.bool_], in_columns: NDArray[np.bool_]) -> "Roadmap":
        """Return the roadmap of a grid in which some moves between free cells are missing, in both directions.

        Parameters
        ----------
        free : (h, w) bool array
            True where a robot may stand.
        in_rows : (h, w − 1) bool array
            True where a robot may move between a cell and the next one of its row.
        in_columns : (h − 1, w) bool array
            True where a robot may move between a cell and the next one of its column.
        """
        cells, numbers, near = _beside(free)
        rows, columns = cells.T
        down, right = np.pad(in_columns, ((1, 1), (0, 0))), np.pad(in_rows, ((0, 0), (1, 1)))
        exists = (down[rows, columns], down[rows + 1, columns], right[rows, columns], right[rows, columns + 1])
        both = _packed(np.where(np.stack(exists, axis=1), near, BLOCKED))
        return cls(both, both, cells, numbers)

    @classmethod
    def of_pairs(cls, count: int, moves: NDArray[np.int32]) -> "Roadmap":
        """Return the roadmap of some cells, which count as the cells of one row, by the moves between them.

        Parameters
        ----------
        count : int
            Number of cells.
        moves : (m, 2) int32 array
            Cells from and to which robots may move, each pair once; at most four from each cell, and to each.
        """
        neighbours = _ends_of(count, moves[:, 0], moves[:, 1])
        incoming = _ends_of(count, moves[:, 1], moves[:, 0])
        numbers = np.arange(count, dtype=np.int32)
        cells = np.stack([np.zeros_like(numbers), numbers], axis=1)
        return cls(neighbours, incoming, cells, numbers[np.newaxis])

    def without(self, cells: Iterable[int]) -> "Roadmap":
        """Return the roadmap without the moves from and to some cells, which keep their numbers."""
        gone = np.zeros(len(self), np.bool_)
        gone[list(cells)] = True
        return self.without_moves(gone[:, np.newaxis] | gone[self.neighbours])

    def for_size(self, size: int) -> "Roadmap":
        """Return the roadmap without the moves into cells that robots of a size do not enter."""
        if not len(self.barred) or not self.barred[size].any():
            return self
        return self.without_moves(self.barred[size][self.neighbours])

    def without_moves(self, closed: NDArray[np.bool_]) -> "Roadmap":
        """Return the roadmap without some moves; the moves back may stay, so that others are one-way.

        Parameters
        ----------
        closed : (v, 4) bool array
            True for the moves to ``neighbours`` that are closed.
        """
        neighbours = _packed(np.where(closed, BLOCKED, self.neighbours))
        return replace(self, neighbours=neighbours, incoming=_incoming(neighbours))

    @property
    def moves(self) -> NDArray[np.int32]:
        """Cells from and to which robots may move, (m, 2) int32, by the cells from which they do."""
        starts, which = np.nonzero(self.neighbours != BLOCKED)
        return np.stack([starts.astype(np.int32), self.neighbours[starts, which]], axis=1)

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


def _beside(free: NDArray[np.bool_]) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Return row and column of each cell, the numbers of a grid, and the four cells beside each, `BLOCKED` for none.

    The four are in the row before, the row behind, the column before and the column behind.
    """
    rows, columns = np.nonzero(free)
    numbers = np.full(free.shape, BLOCKED, np.int32)
    numbers[rows, columns] = np.arange(len(rows), dtype=np.int32)
    padded = np.pad(numbers, 1, constant_values=BLOCKED)
    beside = ((0, 1), (2, 1), (1, 0), (1, 2))
    near = np.stack([padded[rows + down, columns + right] for down, right in beside], axis=1)
    return np.stack([rows, columns], axis=1).astype(np.int32), numbers, near


def _packed(near: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return neighbours with all that are `BLOCKED` behind the others, (v, 4) int32."""
    last = np.argsort(near == BLOCKED, axis=1, kind="stable")
    return np.ascontiguousarray(np.take_along_axis(near, last, axis=1), np.int32)


def _incoming(neighbours: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the cells from which moves lead into each cell, (v, 4) int32."""
    starts, moves = np.nonzero(neighbours != BLOCKED)
    return _ends_of(len(neighbours), neighbours[starts, moves], starts.astype(np.int32))


def _ends_of(count: int, starts: NDArray[np.int32], ends: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the ends of the moves from each cell, (v, 4) int32; `BLOCKED` behind the last one."""
    order = np.argsort(starts, kind="stable")
    starts, ends = starts[order], ends[order]
    place = np.arange(len(starts)) - np.searchsorted(starts, starts)
    found = np.full((count, 4), BLOCKED, np.int32)
    found[starts, place] = ends
    return found
