"""Planner over the floors of a building, with an index of each floor in this process."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.layout import BuildingLayout
from ppaas.buildings.planning.doors import with_doors_shut
from ppaas.buildings.planning.network import Network
from ppaas.buildings.planning.routes import DIRECT, Goal, Route, Start, alternatives
from ppaas.buildings.planning.times import BuildingState, Matrix, Times, Traveller
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, InvalidBuilding, StartOccupied
from ppaas.planners.batch.path_lengths import Cells, PathLengths
from ppaas.planners.ends import Cell
from ppaas.planners.watch import proceed

Spot = tuple[str, float, float]
"""Place in a building: floor, and x, y in the frame of its map [m]."""

_MORE = math.sqrt(2.0) - 1.0
_SAME = 1e-9
_NO_CELLS = np.empty((0, 2), np.int32)


@dataclass(frozen=True, slots=True)
class BuildingPath:
    """Route with the paths at both ends.

    Parameters
    ----------
    route : Route
    goal : Goal
    first, last : (n, 2) int32 array
        Cells of the path from the start to the first junction, and from the last one to the goal; ``last`` is empty if
        the robot drives directly.
    """

    route: Route
    goal: Goal
    first: Cells
    last: Cells


class FloorPaths:
    """Paths on a floor whose doors count as walls, and the cells of its junctions.

    Parameters
    ----------
    paths : PathLengths
    places : sequence of (x, y, yaw)
        Junctions of the floor.
    check : callable
        Called often; an exception from it ends the work.
    """

    def __init__(
        self, paths: PathLengths, places: Sequence[tuple[float, float, float]], check: Callable[[], None] = proceed
    ) -> None:
        self.paths = paths
        self.cells = [paths.cell(x, y) for x, y, _ in places]
        self.lengths = paths.between(self.cells, self.cells, check)
        self._resolution = paths.costmap.info.resolution
        # A junction that is in a wall is infinitely far away.
        self._rows, self._columns = (
            np.array([math.inf if cell is None else cell[axis] for cell in self.cells]) for axis in (0, 1)
        )

    def bounds(self, cell: Cell) -> Matrix:
        """Return lower bounds of the lengths from a cell to the junctions [m]."""
        rows, columns = np.abs(self._rows - cell[0]), np.abs(self._columns - cell[1])
        bounds: Matrix = self._resolution * (np.maximum(rows, columns) + _MORE * np.minimum(rows, columns))
        return bounds

    def apart(self, cell: Cell, other: Cell) -> float:
        """Return a lower bound of the length between two cells [m]."""
        rows, columns = abs(cell[0] - other[0]), abs(cell[1] - other[1])
        return self._resolution * (max(rows, columns) + _MORE * min(rows, columns))


class _FromEnd:
    """Times from an end to the junctions of its floor: lower bounds, and exact ones with paths once they are needed."""

    __slots__ = ("_cell", "_floor", "_speed", "paths", "seconds")

    def __init__(self, floor: FloorPaths, cell: Cell, speed: float) -> None:
        self._floor, self._cell, self._speed = floor, cell, speed
        self.seconds = floor.bounds(cell) / speed
        self.paths: list[Cells | None] = [None] * len(floor.cells)

    def measure(self, number: int) -> float:
        """Compute the path to a junction, and return by how much its time exceeds the bound [s]."""
        cell, paths = self._floor.cells[number], self._floor.paths
        assert cell is not None  # its bound is finite
        path = self.paths[number] = paths.path(self._cell, cell)
        bound, exact = self.seconds.item(number), paths.length(path) / self._speed
        self.seconds[number] = exact
        return exact - bound


def _of(path: Cells | None) -> Cells:
    assert path is not None
    return path


class BuildingPlanner:
    """Plans exactly over the floors of a building.

    Parameters
    ----------
    layout : BuildingLayout
    costmaps : mapping of str to Costmap
        Read-only costmap of each floor, by its name, without doors.
    threads : int
        Largest number of threads that build an index.
    check : callable
        Called often while the planner is made; an exception from it ends the work.

    Raises
    ------
    InvalidBuilding
        A floor has no costmap.
    InvalidPlanner
        A floor is too large or too cluttered for an index.
    """

    def __init__(
        self,
        layout: BuildingLayout,
        costmaps: Mapping[str, Costmap],
        *,
        threads: int = 1,
        check: Callable[[], None] = proceed,
    ) -> None:
        self.network = Network(layout)
        self.state = BuildingState(self.network)
        self.floors = list[FloorPaths]()
        for number, name in enumerate(self.network.floors):
            if name not in costmaps:
                raise InvalidBuilding(f"there is no costmap of floor {name!r}")
            lines = [door.ends for door in layout.doors if door.floor == name]
            paths = PathLengths(with_doors_shut(costmaps[name], lines), threads=threads, check=check)
            places = [self.network.junctions[each].place for each in self.network.parts[number]]
            self.floors.append(FloorPaths(paths, places, check))
            self.state.measure(number, self.floors[number].lengths)

    def times(self, traveller: Traveller) -> Times:
        """Return the times of a robot in the building as it is, also after changes of ``state``."""
        return Times(self.state, traveller)

    def plan(self, times: Times, start: Spot, goal: Spot) -> BuildingPath | None:
        """Return the best route and the paths at its ends; None if there is none.

        A path is computed only to junctions that may be on the best route: those with the least sum of a lower bound,
        the exact time between both floors and another lower bound, until both are exact.

        Raises
        ------
        InvalidBuilding
            There is no such floor.
        StartOccupied, GoalOccupied
            The place is outside the map of its floor, or no free cell is near it.
        """
        here, there = self._number(start[0]), self._number(goal[0])
        one, other = self.floors[here], self.floors[there]
        a, b = self._cell(start, here, StartOccupied), self._cell(goal, there, GoalOccupied)
        leaving, entering = _FromEnd(one, a, times.traveller.speed), _FromEnd(other, b, times.traveller.speed)
        total = leaving.seconds[:, None] + times.between(here, there) + entering.seconds
        direct, cells = (one.apart(a, b) / times.traveller.speed, None) if here == there else (math.inf, _NO_CELLS)
        while True:
            at = int(total.argmin()) if total.size else -1
            least = total.item(at) if at >= 0 else math.inf
            if direct <= least:
                if cells is not None:
                    break
                cells = one.paths.path(a, b)
                direct = one.paths.length(cells) / times.traveller.speed
                continue
            row, column = divmod(at, total.shape[1])
            if leaving.paths[row] is None:
                total[row] += leaving.measure(row)
            if entering.paths[column] is None:
                total[:, column] += entering.measure(column)
            if total.item(at) <= least + _SAME:
                chain = times.chain(self.network.parts[here].start + row, self.network.parts[there].start + column)
                route = Route(least, Start(here, leaving.seconds, direct), chain)
                first, last = leaving.paths[row], entering.paths[column]
                return BuildingPath(route, Goal(there, entering.seconds), _of(first), _of(last)[::-1])
        if direct == math.inf:
            return None
        route = Route(direct, Start(here, leaving.seconds, direct), DIRECT)
        return BuildingPath(route, Goal(there, entering.seconds), cells, _NO_CELLS)

    def alternatives(self, times: Times, start: Spot, goal: Spot, count: int) -> tuple[list[Route], Goal]:
        """Return up to ``count`` routes by other lifts and ways, the best first, and the goal with its times.

        Raises as ``plan`` does.
        """
        here, there = self._number(start[0]), self._number(goal[0])
        begin, end = self.start(times, start), self.goal(times, goal)
        if here == there:
            a, b = self._cell(start, here, StartOccupied), self._cell(goal, there, GoalOccupied)
            paths = self.floors[here].paths
            begin = Start(here, begin.seconds, paths.length(paths.path(a, b)) / times.traveller.speed)
        return alternatives(times, [begin], end, count), end

    def start(self, times: Times, spot: Spot) -> Start:
        """Return a start with its times to all junctions of its floor; raises as ``plan`` does."""
        floor = self._number(spot[0])
        cell = self._cell(spot, floor, StartOccupied)
        return Start(floor, self._lengths(floor, [cell])[0] / times.traveller.speed)

    def goal(self, times: Times, spot: Spot) -> Goal:
        """Return a goal with its times from all junctions of its floor; raises as ``plan`` does."""
        floor = self._number(spot[0])
        cell = self._cell(spot, floor, GoalOccupied)
        return Goal(floor, self._lengths(floor, [cell])[0] / times.traveller.speed)

    def costs(self, times: Times, starts: Iterable[Spot], goals: Iterable[Spot]) -> NDArray[np.float64]:
        """Return the (n, m) times from each start to each goal [s], infinite without a route; raises as ``plan``."""
        begins, ends = list(starts), list(goals)
        begun, ended = [self.start(times, each) for each in begins], [self.goal(times, each) for each in ends]
        costs = np.full((len(begins), len(ends)), math.inf)
        for row, (start, begin) in enumerate(zip(begun, begins, strict=True)):
            for column, (goal, end) in enumerate(zip(ended, ends, strict=True)):
                total = start.seconds[:, None] + times.between(start.floor, goal.floor) + goal.seconds
                costs[row, column] = total.min(initial=math.inf)
                if start.floor == goal.floor:
                    costs[row, column] = min(
                        costs[row, column], self._direct(start.floor, begin, end) / times.traveller.speed
                    )
        return costs

    def _direct(self, floor: int, start: Spot, goal: Spot) -> float:
        a, b = self._cell(start, floor, StartOccupied), self._cell(goal, floor, GoalOccupied)
        return self.floors[floor].paths.length(self.floors[floor].paths.path(a, b))

    def _lengths(self, floor: int, cells: list[Cell | None]) -> Matrix:
        return self.floors[floor].paths.between(cells, self.floors[floor].cells)

    def _number(self, floor: str) -> int:
        try:
            return self.network.number_of[floor]
        except KeyError:
            self.network.layout.building.floor(floor)
            raise

    def _cell(self, spot: Spot, floor: int, error: type[StartOccupied] | type[GoalOccupied]) -> Cell:
        cell = self.floors[floor].paths.cell(spot[1], spot[2])
        if cell is None:
            raise error(f"no free cell is near x={spot[1]:.3f} y={spot[2]:.3f} on floor {spot[0]!r}")
        return cell
