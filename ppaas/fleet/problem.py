"""Problem: starts and goals of a fleet on a roadmap, checked, with the distances of all cells from each goal."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, NoValidPath
from ppaas.fleet.kernels.board import NO_GUIDE, NOT_BARRED, ONE_SIZE, UNREACHABLE, Board
from ppaas.fleet.kernels.distances import flood_all
from ppaas.fleet.roadmap import Roadmap
from ppaas.planners.watch import proceed

SLICE = 1 << 22
"""Number of distances that are computed between two checks: some 10 ms."""


@dataclass(frozen=True, slots=True)
class FleetProblem:
    """Starts and goals of a fleet.

    Parameters
    ----------
    roadmap : Roadmap
    starts, goals : (n,) int32 array
        Cells; no two starts and no two goals are the same.
    distances : (n, v) int16 array
        Distance of each cell from each goal, `UNREACHABLE` without a way.
    """

    roadmap: Roadmap
    starts: NDArray[np.int32]
    goals: NDArray[np.int32]
    distances: NDArray[np.int16]

    @classmethod
    def of(
        cls,
        roadmap: Roadmap,
        starts: NDArray[np.int64],
        goals: NDArray[np.int64],
        check: Callable[[], None] = proceed,
    ) -> "FleetProblem":
        """Check starts and goals, and compute the distances.

        Parameters
        ----------
        roadmap : Roadmap
        starts, goals : (n, 2) int64 array
            Row and column of each robot.
        check : callable
            Called every few milliseconds; ends the work by raising.

        Raises
        ------
        InvalidInput
            A start or goal is outside the map or blocked, two are the same, or the numbers of both differ.
        NoValidPath
            A robot cannot reach its goal.
        """
        if len(starts) != len(goals):
            raise InvalidInput(f"there are {len(starts)} starts and {len(goals)} goals; give as many of both")
        first, last = roadmap.at(starts, "start"), roadmap.at(goals, "goal")
        for cells, what in ((first, "starts"), (last, "goals")):
            check_distinct(cells, roadmap, what)
        problem = cls(roadmap, first, last, distances_from(roadmap, last, check))
        for robot in np.nonzero(problem.least == UNREACHABLE)[0][:1]:
            raise NoValidPath(f"robot {robot} cannot reach its goal, not even without other robots")
        return problem

    def __len__(self) -> int:
        """Return the number of robots."""
        return len(self.starts)

    @property
    def least(self) -> NDArray[np.int64]:
        """Length of the shortest path of each robot, (n,) int64 [cells]."""
        return self.distances[np.arange(len(self)), self.starts].astype(np.int64)

    @property
    def bound(self) -> int:
        """Sum of the lengths of shortest paths."""
        return int(self.least.sum())

    def board(self, guide: NDArray[np.int8] = NO_GUIDE) -> Board:
        """Return the arrays for kernels, with guides of the robots."""
        return board_of(self.roadmap, self.distances, guide, self.goals)


def board_of(
    roadmap: Roadmap,
    distances: NDArray[np.int16],
    guide: NDArray[np.int8],
    goals: NDArray[np.int32],
    sizes: NDArray[np.int8] | None = None,
) -> Board:
    """Return the arrays of a roadmap and of robots for kernels; without sizes, robots may enter all cells."""
    barred = NOT_BARRED if sizes is None else roadmap.barred
    own = ONE_SIZE if sizes is None else sizes
    return Board(roadmap.neighbours, distances, guide, goals, roadmap.areas, roadmap.room, barred, own)


def distances_from(
    roadmap: Roadmap, goals: NDArray[np.int32], check: Callable[[], None] = proceed
) -> NDArray[np.int16]:
    """Return the distance of each cell from each goal, (n, v) int16 [cells]; `UNREACHABLE` without a way.

    Raises
    ------
    InvalidInput
        A distance is greater than a table may hold.
    """
    distances = np.empty((len(goals), len(roadmap)), np.int16)
    queue = np.empty(len(roadmap), np.int32)
    at_once = max(1, SLICE // max(1, len(roadmap)))
    for begin in range(0, len(goals), at_once):
        check()
        rows = slice(begin, begin + at_once)
        if not flood_all(roadmap.incoming, goals[rows], distances[rows], queue):
            raise InvalidInput(f"the map is too large: two of its cells are {UNREACHABLE} moves apart")
    return distances


def check_distinct(cells: NDArray[np.int32], roadmap: Roadmap, what: str) -> None:
    """Raise ``InvalidInput`` if two of the cells are the same; ``what`` names them."""
    order = np.argsort(cells, kind="stable")
    for k in np.nonzero(np.diff(cells[order]) == 0)[0][:1]:
        row, column = roadmap.cells[cells[order[k]]]
        one, other = order[k], order[k + 1]
        raise InvalidInput(f"the {what} of robots {one} and {other} are the same cell: row {row} column {column}")


def is_connected(roadmap: Roadmap, one: int, other: int) -> bool:
    """Return whether there is a way from one cell to another, without regard to robots."""
    return bool(distances_from(roadmap, np.array([other], np.int32))[0, one] < UNREACHABLE)
