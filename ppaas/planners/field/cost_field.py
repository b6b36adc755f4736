"""Cost field: the cost of the cheapest path from each cell of a map to the nearest goal.

The value of a cell is the minimum, over its eight neighbours n, of value(n) + w(cell)·(1 or √2), and 0 at a goal. A
diagonal move needs both cells beside it free. Weights come from `ppaas.planners.weights`. The field is exact in
fixed point, and identical bit for bit for any number of threads and any slicing of the work.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput
from ppaas.planners.ends import Cell
from ppaas.planners.field.base import GridField
from ppaas.planners.field.queue_field import QueueField
from ppaas.planners.field.tile_field import PathTooLong, TileField, suits_tiles
from ppaas.planners.watch import proceed
from ppaas.planners.weights import passable


class CostField(GridField):
    """Cost field that grows from its goals in slices: by tiles, or with a bucket queue on maps that do not suit tiles.

    Parameters
    ----------
    costmap : Costmap
        Only read; it must not change before the last path is read.
    goals : (n, 2) array
        Row, column of free cells on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    threads : int
        Maximum number of threads of the kernels.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.
    """

    def __init__(
        self,
        costmap: Costmap,
        goals: NDArray[np.integer],
        *,
        allow_unknown: bool = True,
        threads: int = 1,
        check: Callable[[], None] = proceed,
    ) -> None:
        def by_queue() -> QueueField:
            return QueueField(costmap, goals, allow_unknown=allow_unknown, threads=threads, check=check)

        self._by_queue = by_queue
        tiles = None
        if suits_tiles(costmap.info.shape):
            tiles = TileField(costmap, goals, allow_unknown=allow_unknown, threads=threads, check=check)
        self._field = by_queue() if tiles is None or tiles.is_winding else tiles

    @property
    def settled(self) -> int:
        """Number of cells with their final value."""
        return self._field.settled

    def grow(self, target: Cell | None = None) -> bool:
        """Grow the field until the value of ``target`` is final, or over the whole map.

        Returns
        -------
        bool
            Whether ``target`` can be reached; true without a target.
        """
        try:
            return self._field.grow(target)
        except PathTooLong:
            self._field = self._by_queue()
            return self._field.grow(target)

    def path_from(self, cell: Cell) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path from ``cell``, whose value must be final, to a goal."""
        return self._field.path_from(cell)

    def values(self) -> NDArray[np.float64]:
        """Return the (height, width) costs-to-go; infinite if blocked or not reached."""
        return self._field.values()

    def values_at(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n,) costs-to-go of (n, 2) cells, row and column; infinite if blocked or not reached."""
        return self._field.values_at(cells)


def cost_field(
    costmap: Costmap,
    goal_xy: ArrayLike | None = None,
    *,
    cells: ArrayLike | None = None,
    allow_unknown: bool = True,
    threads: int = 1,
) -> NDArray[np.float64]:
    """Return the cost of the cheapest path from each cell to the nearest goal.

    Parameters
    ----------
    costmap : Costmap
    goal_xy : (2,) or (n, 2) array, optional
        Goals x, y in the frame of the costmap [m].
    cells : (2,) or (n, 2) array, optional
        Goals as row, column; an alternative to ``goal_xy``.
    allow_unknown : bool
        Whether unknown cells may be entered.
    threads : int
        Maximum number of threads.

    Returns
    -------
    (height, width) array
        Costs-to-go; infinite if no goal can be reached.

    Raises
    ------
    InvalidInput
        Not exactly one of ``goal_xy`` and ``cells`` is given, or it is empty, or not finite.
    GoalOutsideMap, GoalOccupied
    """
    if (goal_xy is None) == (cells is None):
        raise InvalidInput("give the goals either as goal_xy or as cells, not both")
    if goal_xy is not None:
        points = np.asarray(goal_xy, dtype=np.float64)
        if not np.isfinite(points).all():
            raise InvalidInput("goals must be finite x, y [m]")
        cells = costmap.info.to_cells(points)
    goals = np.atleast_2d(np.asarray(cells, dtype=np.int64))
    _check_goals(costmap, goals, allow_unknown)
    field = CostField(costmap, goals, allow_unknown=allow_unknown, threads=threads)
    field.grow()
    return field.values()


def _check_goals(costmap: Costmap, goals: NDArray[np.int64], allow_unknown: bool) -> None:
    if goals.ndim != 2 or goals.shape[1:] != (2,) or not len(goals):
        raise InvalidInput(f"goals must be one or more pairs, not an array of shape {goals.shape}")
    outside = (goals < 0).any(axis=1) | (goals >= costmap.info.shape).any(axis=1)
    if outside.any():
        raise GoalOutsideMap(
            f"the goal in row, column {goals[outside][0].tolist()} is outside the map, whose shape is "
            f"{costmap.info.shape}"
        )
    blocked = ~passable(allow_unknown)[costmap.data[goals[:, 0], goals[:, 1]]]
    if blocked.any():
        raise GoalOccupied(f"the goal in row, column {goals[blocked][0].tolist()} is blocked; choose a free cell")
