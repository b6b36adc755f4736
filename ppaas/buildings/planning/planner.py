"""Planner over the floors of a building, with an index of each floor in this process."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.layout import BuildingLayout
from ppaas.buildings.planning.doors import with_doors_shut
from ppaas.buildings.planning.network import BuildingNetwork, JunctionChain
from ppaas.buildings.planning.routes import DIRECT, Route, RouteEnd, RouteStart, alternatives
from ppaas.buildings.planning.times import BuildingState, BuildingTimes, Matrix, Traveller
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, InvalidBuilding, StartOccupied
from ppaas.planners.batch.path_lengths import Cells, PathLengths
from ppaas.planners.ends import Cell
from ppaas.planners.watch import proceed

Spot = tuple[str, float, float]
"""Place in a building: floor, and x, y in the frame of its map [m]."""

_MORE = math.sqrt(2.0) - 1.0
_SAME = 1e-6
"""Lengths that differ by less are the same [m]."""
_NO_CELLS = np.empty((0, 2), np.int32)


class BuildingPath(NamedTuple):
    """Best route, with the paths at both ends.

    Parameters
    ----------
    seconds : float
        Time from start to goal [s].
    chain : JunctionChain
        Junctions on the way, and the lifts and ways that are taken.
    first, last : (n, 2) int32 array
        Cells of the path from the start to the first junction, and from the last one to the goal; ``last`` is empty if
        the robot drives directly.
    floors : (int, int)
        Floors of start and goal.
    speed : float
        Speed of the robot [m/s].
    metres : (array, array, float)
        Lengths from the start, and from the goal, to the junctions of their floors, and between both [m]: exact where
        the route leads, and elsewhere lower bounds.
    """

    seconds: float
    chain: JunctionChain
    first: Cells
    last: Cells
    floors: tuple[int, int]
    speed: float
    metres: tuple[Matrix, Matrix, float]

    @property
    def route(self) -> Route:
        """The route, of which ``legs_of`` makes legs."""
        start = RouteStart(self.floors[0], self.metres[0] / self.speed, self.metres[2] / self.speed)
        return Route(self.seconds, start, self.chain)

    @property
    def goal(self) -> RouteEnd:
        """The goal, with its times."""
        return RouteEnd(self.floors[1], self.metres[1] / self.speed)


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
        self.reaches = np.isfinite(self.lengths)
        self._resolution = paths.costmap.info.resolution
        # A junction that is in a wall is infinitely far away.
        self._places = np.array([complex(math.inf) if cell is None else complex(*cell) for cell in self.cells])

    def bounds(self, cell: Cell) -> Matrix:
        """Return lower bounds of the lengths from a cell to the junctions [m]: the distances."""
        bounds: Matrix = self._resolution * np.abs(self._places - complex(*cell))
        return bounds

    def apart(self, cell: Cell, other: Cell) -> float:
        """Return a lower bound of the length between two cells [m]."""
        rows, columns = abs(cell[0] - other[0]), abs(cell[1] - other[1])
        return self._resolution * (max(rows, columns) + _MORE * min(rows, columns))


class _FromEnd:
    """Lengths from an end to the junctions of its floor: lower bounds, and exact ones with paths once they are needed.

    Parameters
    ----------
    floor : FloorPaths
    cell : (row, column)
    """

    __slots__ = ("_cell", "_floor", "metres", "paths")

    def __init__(self, floor: FloorPaths, cell: Cell) -> None:
        self._floor, self._cell = floor, cell
        self.metres = floor.bounds(cell)
        self.paths: list[Cells | None] = [None] * len(floor.cells)

    def measure(self, number: int) -> float:
        """Compute the path to a junction unless it is known, and return by how much its length exceeds the bound [m].

        The other bounds rise by the triangle inequality: two junctions are not farther apart than by way of the end.
        """
        if self.paths[number] is not None:
            return 0.0
        cell, floor, metres = self._floor.cells[number], self._floor, self.metres
        assert cell is not None  # its bound is finite
        path = self.paths[number] = floor.paths.path(self._cell, cell)
        length, bound = floor.paths.length(path), metres.item(number)
        if length < math.inf:
            np.maximum(metres, np.abs(floor.lengths[number] - length), out=metres)
        else:
            metres[floor.reaches[number]] = math.inf
        metres[number] = length
        return length - bound


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
        self.network = BuildingNetwork(layout)
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

    def times(self, traveller: Traveller) -> BuildingTimes:
        """Return the times of a robot in the building as it is, also after changes of ``state``."""
        return BuildingTimes(self.state, traveller)

    def plan(self, times: BuildingTimes, start: Spot, goal: Spot) -> BuildingPath | None:
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
        leaving, entering, speed = _FromEnd(one, a), _FromEnd(other, b), times.traveller.speed
        between = times.metres_between(here, there)
        direct, cells = (one.apart(a, b), None) if here == there else (math.inf, _NO_CELLS)
        while True:
            total = leaving.metres[:, None] + between + entering.metres
            at = int(total.argmin()) if total.size else -1
            least = total.item(at) if at >= 0 else math.inf
            if direct <= least:
                if cells is not None:
                    break
                cells = one.paths.path(a, b)
                direct = one.paths.length(cells)
                continue
            row, column = divmod(at, total.shape[1])
            if leaving.measure(row) + entering.measure(column) <= _SAME:
                chain = times.chain(self.network.parts[here].start + row, self.network.parts[there].start + column)
                metres = leaving.metres, entering.metres, direct
                first, last = _of(leaving.paths[row]), _of(entering.paths[column])[::-1]
                return BuildingPath(least / speed, chain, first, last, (here, there), speed, metres)
        if direct == math.inf:
            return None
        metres = leaving.metres, entering.metres, direct
        return BuildingPath(direct / speed, DIRECT, cells, _NO_CELLS, (here, there), speed, metres)

    def alternatives(self, times: BuildingTimes, start: Spot, goal: Spot, count: int) -> tuple[list[Route], RouteEnd]:
        """Return up to ``count`` routes by other lifts and ways, the best first, and the goal with its times.

        Raises as ``plan`` does.
        """
        here, there = self._number(start[0]), self._number(goal[0])
        begin, end = self.start(times, start), self.goal(times, goal)
        if here == there:
            a, b = self._cell(start, here, StartOccupied), self._cell(goal, there, GoalOccupied)
            paths = self.floors[here].paths
            begin = RouteStart(here, begin.seconds, paths.length(paths.path(a, b)) / times.traveller.speed)
        return alternatives(times, [begin], end, count), end

    def start(self, times: BuildingTimes, spot: Spot) -> RouteStart:
        """Return a start with its times to all junctions of its floor; raises as ``plan`` does."""
        floor = self._number(spot[0])
        cell = self._cell(spot, floor, StartOccupied)
        return RouteStart(floor, self._lengths(floor, [cell])[0] / times.traveller.speed)

    def goal(self, times: BuildingTimes, spot: Spot) -> RouteEnd:
        """Return a goal with its times from all junctions of its floor; raises as ``plan`` does."""
        floor = self._number(spot[0])
        cell = self._cell(spot, floor, GoalOccupied)
        return RouteEnd(floor, self._lengths(floor, [cell])[0] / times.traveller.speed)

    def costs(self, times: BuildingTimes, starts: Iterable[Spot], goals: Iterable[Spot]) -> NDArray[np.float64]:
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
