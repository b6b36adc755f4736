"""A field of costs-to-go that one thread grows cell by cell, with a bucket queue: for maps that tiles do not suit."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell
from ppaas.planners.field.base import GridField
from ppaas.planners.field.bucket_queue import BucketQueue
from ppaas.planners.field.kernels.descent import descend
from ppaas.planners.field.kernels.layout import AT_GOAL, BLOCKED, BUCKET_SHIFT, RING, UNREACHED, UNREACHED_WIDE
from ppaas.planners.field.kernels.propagation import TOO_NARROW, propagate, seed
from ppaas.planners.field.kernels.setup import lay
from ppaas.planners.helper_threads import share
from ppaas.planners.kernels.moves import PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, fixed_weights

SLICE_CELLS = 50_000
"""Cells settled between two checks: about 3 ms."""
SLICE_WALKED = 50_000
"""Cells walked along between two checks."""
SLICE_READ = 1 << 18
"""Cells whose values are given out between two checks: about 3 ms."""
SLICE_LAID = 1 << 18
"""Cells set up between two checks: 0.04 ms, where memory is new 0.15."""
SLICES_EACH = 4
"""So many slices must be to set up for each thread: for less nobody is called."""


class QueueField(GridField):
    """The padded costs of a map and a value for each of its cells, which grow from the goals outward.

    It takes paths of any length: where values outgrow 32 bits it carries on in 64.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    goals : (n, 2) array
        Row, column of free cells on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    threads : int
        Most threads that kernels may use; only to set up.
    check : callable
        Called at least every few milliseconds of work; what it raises ends the work.
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
        self._check = check
        self._shape = costmap.info.height + 2, costmap.info.width + 2
        self._weights = fixed_weights()
        self._limit = int(UNREACHED) - 1
        self._bound: int | None = None
        costs, field = np.empty(self._shape, np.uint8), np.empty(self._shape, np.uint32)
        slices = self._row_slices()

        def lay_rows(rows: tuple[int, int]) -> None:
            lay(costmap.data, allow_unknown, costs, field, *rows)

        share(slices, lay_rows, helpers=min(threads, len(slices) // SLICES_EACH) - 1, check=check)
        self._costs = costs.ravel()
        self._field: NDArray[np.uint32] | NDArray[np.int64] = field.ravel()
        self._queue = BucketQueue(len(goals))
        flat = (goals[:, 0].astype(np.int64) + 1) * self._shape[1] + goals[:, 1] + 1
        q = self._queue
        seed(self._field, flat, q.pool, q.links, q.heads, q.fills, q.state)

    @property
    def settled(self) -> int:
        """How many cells have their final value; those that cost more than the last target are not counted."""
        most = int(self._unreached) - 1 if self._bound is None else self._bound
        count, rows = 0, self._field.reshape(self._shape)
        for first, last in self._row_slices():
            self._check()
            values = rows[first:last]
            count += int(np.count_nonzero((values != BLOCKED) & (values <= most)))
        return count

    def grow(self, target: Cell | None = None) -> bool:
        """Let it grow until the value of ``target`` is final, or all over the map.

        Returns
        -------
        bool
            Whether ``target`` can be reached; without one, true.
        """
        wanted = -1 if target is None else self._flat(target)
        while True:
            self._check()
            q = self._queue
            outcome = propagate(
                self._field, self._costs, self._shape[1], self._weights,
                q.pool, q.links, q.heads, q.fills, q.state, wanted, self._limit, SLICE_CELLS,
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                q.grow(self._check)
            elif outcome == TOO_NARROW:
                self._widen()
            elif outcome == SETTLED:
                self._bound = max(int(self._field[wanted]), self._bound or 0)
                return True
            elif outcome != PAUSED:
                self._bound = None
                return target is None

    def path_from(self, cell: Cell) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path from ``cell``, whose value must be final, to a goal."""
        most = (int(self._field[self._flat(cell)]) - AT_GOAL) // round(SCALE * NEUTRAL) + 1
        cells = np.empty((most, 2), np.int32)
        cells[0] = cell
        count, before = 1, 0
        while count > before:
            self._check()
            before = count
            count = descend(
                self._field, self._costs, self._shape[1], self._weights,
                cells, count, min(SLICE_WALKED, most - count),
            )  # fmt: skip
        return cells[:count].copy()

    def values(self) -> NDArray[np.float64]:
        """Return the (height, width) costs-to-go; infinite where blocked or not reached."""
        values, inner = np.empty((self._shape[0] - 2, self._shape[1] - 2)), self._field.reshape(self._shape)[1:-1, 1:-1]
        rows = max(1, SLICE_READ // self._shape[1])
        for first in range(0, len(values), rows):
            self._check()
            values[first : first + rows] = self._costs_to_go(inner[first : first + rows])
        return values

    def values_at(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n,) costs-to-go of (n, 2) cells, row and column; infinite where blocked or not reached."""
        return self._costs_to_go(self._field[(cells[:, 0].astype(np.int64) + 1) * self._shape[1] + cells[:, 1] + 1])

    def _costs_to_go(self, values: NDArray[np.uint32] | NDArray[np.int64]) -> NDArray[np.float64]:
        reached = (values != BLOCKED) & (values != self._unreached)
        return np.where(reached, (values.astype(np.float64) - AT_GOAL) / SCALE, np.inf)

    @property
    def _unreached(self) -> np.uint32 | np.int64:
        return UNREACHED if self._field.dtype == np.uint32 else UNREACHED_WIDE

    def _flat(self, cell: Cell) -> int:
        return (cell[0] + 1) * self._shape[1] + cell[1] + 1

    def _row_slices(self) -> list[tuple[int, int]]:
        rows = max(1, SLICE_LAID // self._shape[1])
        return [(first, min(first + rows, self._shape[0])) for first in range(0, self._shape[0], rows)]

    def _widen(self) -> None:
        """Carry on in 64 bits: the path is too long for 32."""
        narrow = self._field.reshape(self._shape)
        wide = np.empty(self._shape, np.int64)
        for first, last in self._row_slices():
            self._check()
            wide[first:last] = narrow[first:last]
            wide[first:last][narrow[first:last] == UNREACHED] = UNREACHED_WIDE
        self._field = wide.ravel()
        self._limit = int(UNREACHED_WIDE) - (RING << BUCKET_SHIFT)
