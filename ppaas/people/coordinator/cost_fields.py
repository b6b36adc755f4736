"""Costs of shortest paths between robots and people, by one cost field a person or a robot, whichever is fewer.

Fields are grown by Dijkstra's algorithm over a coarse costmap, in a window around their source: who sees a person is
near. A cycle grows a bounded number of cells, cells of followed people's fields first, then the oldest fields.
"""

import math
from collections.abc import Iterable, Mapping, Sequence, Set

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo
from ppaas.planners.field.cost_field import CostField

Position = tuple[float, float]
Ints = NDArray[np.int64]

CELL = 0.2
"""Edge of a coarse cell, unless the map's cells are larger [m]."""
WINDOW = 16.0
"""Distance from its source that a field covers to each side [m]."""
NEAREST = 1.0
"""Largest distance between a person or a robot and a free cell [m]."""


def coarse(costmap: Costmap, cell: float = CELL) -> tuple[Costmap, int]:
    """Return a costmap of larger cells, and how many cells of the map are along an edge of one.

    A cell is blocked if any of its cells is, unknown if all are, and costs as much as the most expensive otherwise.
    """
    factor = max(1, math.floor(cell / costmap.info.resolution + 1e-6))
    height, width = (-(-side // factor) for side in costmap.info.shape)
    data = np.full((height * factor, width * factor), LETHAL_OBSTACLE, np.uint8)
    data[: costmap.info.height, : costmap.info.width] = costmap.data
    blocks = data.reshape(height, factor, width, factor).swapaxes(1, 2).reshape(height, width, -1)
    unknown = blocks == NO_INFORMATION
    cells = np.where(unknown, 0, blocks).max(axis=2)
    cells[cells >= INSCRIBED_INFLATED_OBSTACLE] = LETHAL_OBSTACLE
    cells[unknown.all(axis=2)] = NO_INFORMATION
    info = GridInfo(costmap.info.resolution * factor, width, height, costmap.info.origin)
    return Costmap(np.ascontiguousarray(cells), info), factor


class PathCosts:
    """Costs from robots to people, as of the last time that each was computed.

    Parameters
    ----------
    costmap : Costmap
    cells_per_cycle : int
        Cells that a cycle may grow; at least one field is.

    Attributes
    ----------
    costs : dict of (str, int) to float
        Cost by robot and person, in units of a plan on the map; infinite without a path.
    """

    def __init__(self, costmap: Costmap, cells_per_cycle: int) -> None:
        self._most = cells_per_cycle
        self.costs: dict[tuple[str, int], float] = {}
        self._age: dict[str | int, int] = {}
        self._cycle = 0
        self.use_costmap(costmap)

    def use_costmap(self, costmap: Costmap) -> None:
        """Replace the map; all costs are computed again."""
        self._costmap, self._factor = coarse(costmap)
        side = 2 * math.ceil(WINDOW / self._costmap.info.resolution) + 1
        self._fields = max(1, self._most // min(side * side, self._costmap.data.size))
        self.costs.clear()
        self._age.clear()

    def update(
        self,
        robots: Mapping[str, Position],
        people: Mapping[int, Position],
        pairs: Set[tuple[str, int]],
        first: Sequence[int],
    ) -> set[int]:
        """Compute the costs of some pairs again.

        Parameters
        ----------
        robots, people : mapping
            Their positions, in the frame of the map [m].
        pairs : set of (robot, person)
            Which costs are wanted; others are forgotten.
        first : sequence of int
            People whose costs are computed first: those who are followed.

        Returns
        -------
        set of int
            Ids of the people whose costs from all robots are new.
        """
        self._cycle += 1
        self.costs = {pair: cost for pair, cost in self.costs.items() if pair in pairs}
        by_person, by_robot = _partners(pairs)
        urgent = sorted((person for person in first if person in by_person), key=self._turn)
        sources: list[str | int] = [*urgent[: self._fields]]
        rest = by_person.keys() if len(by_person) <= len(by_robot) else by_robot.keys()
        waiting = sorted((each for each in rest if each not in sources), key=lambda each: (self._turn(each), str(each)))
        sources += waiting[: max(self._fields - len(sources), 0)]
        for source in sources:
            self._age[source] = self._cycle
            if isinstance(source, int):
                targets = sorted(by_person[source])
                values = self._field(people[source], [robots[name] for name in targets])
                self.costs |= {(name, source): cost for name, cost in zip(targets, values, strict=True)}
            else:
                persons = sorted(by_robot[source])
                values = self._field(robots[source], [people[each] for each in persons])
                self.costs |= {(source, each): cost for each, cost in zip(persons, values, strict=True)}
        self._age = {source: age for source, age in self._age.items() if source in by_person or source in by_robot}
        return {source for source in sources if isinstance(source, int)}

    def _turn(self, source: str | int) -> int:
        return self._age.get(source, 0)

    def by_person(self) -> dict[int, dict[str, float]]:
        """Return all costs, by person and then by Robot ID."""
        costs: dict[int, dict[str, float]] = {}
        for (robot, person), cost in self.costs.items():
            costs.setdefault(person, {})[robot] = cost
        return costs

    def _field(self, source: Position, targets: Sequence[Position]) -> list[float]:
        """Return the costs of the cheapest paths between a source and targets."""
        centre = self._cell(source)
        if centre is None:
            return [math.inf] * len(targets)
        window, corner = self._window(centre)
        cells = [self._cell(target) for target in targets]
        inside = [cell is not None and _within(cell, corner, window.info.shape) for cell in cells]
        wanted = np.array([cell for cell, is_in in zip(cells, inside, strict=True) if is_in], np.int64).reshape(-1, 2)
        field = CostField(window, np.array([centre]) - corner)
        for row, column in (wanted - corner).tolist():
            field.grow((row, column))
        values = iter((self._factor * field.values_at(wanted - corner)).tolist() if len(wanted) else [])
        return [next(values) if is_in else math.inf for is_in in inside]

    def _window(self, centre: tuple[int, int]) -> tuple[Costmap, Ints]:
        """Return the part of the map around a cell, and the cell of its corner."""
        reach = math.ceil(WINDOW / self._costmap.info.resolution)
        low = np.maximum(np.array(centre) - reach, 0)
        high = np.minimum(np.array(centre) + reach + 1, self._costmap.info.shape)
        data = np.ascontiguousarray(self._costmap.data[low[0] : high[0], low[1] : high[1]])
        return Costmap(data, GridInfo(self._costmap.info.resolution, data.shape[1], data.shape[0])), low

    def _cell(self, position: Position) -> tuple[int, int] | None:
        """Return the free cell nearest to a position, if one is near."""
        own = self._costmap.info.cell_of(*position)
        if own is not None and _is_free(int(self._costmap.data[own])):
            return own
        row, column = self._costmap.info.to_cells(position).tolist()
        reach = math.ceil(NEAREST / self._costmap.info.resolution)
        top, left = max(row - reach, 0), max(column - reach, 0)
        part = self._costmap.data[top : max(row + reach + 1, 0), left : max(column + reach + 1, 0)]
        rows, columns = np.nonzero((part < INSCRIBED_INFLATED_OBSTACLE) | (part == NO_INFORMATION))
        if not len(rows):
            return None
        nearest = int(np.argmin((rows + top - row) ** 2 + (columns + left - column) ** 2))
        return int(rows[nearest]) + top, int(columns[nearest]) + left


def _is_free(cost: int) -> bool:
    return cost < INSCRIBED_INFLATED_OBSTACLE or cost == NO_INFORMATION


def _within(cell: Iterable[int], corner: Ints, shape: tuple[int, int]) -> bool:
    return all(0 <= at - low < side for at, low, side in zip(cell, corner.tolist(), shape, strict=True))


def _partners(pairs: Set[tuple[str, int]]) -> tuple[dict[int, set[str]], dict[str, set[int]]]:
    """Return the robots of each person, and the people of each robot."""
    by_person: dict[int, set[str]] = {}
    by_robot: dict[str, set[int]] = {}
    for robot, person in pairs:
        by_person.setdefault(person, set()).add(robot)
        by_robot.setdefault(robot, set()).add(person)
    return by_person, by_robot
