"""Cost field grown cell by cell by one thread with a bucket queue, for maps that do not suit tiles."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.array_growth import doubled
from ppaas.planners.ends import Cell
from ppaas.planners.field.base import GridField
from ppaas.planners.field.kernels.descent import descend
from ppaas.planners.field.kernels.layout import (
    AT_GOAL,
    BLOCKED,
    BUCKET_SHIFT,
    CHUNK,
    MAX_CHUNKS,
    RING,
    UNREACHED,
    UNREACHED_WIDE,
)
from ppaas.planners.field.kernels.propagation import FREE, SPARE, STATE_SIZE, TOO_NARROW, propagate, seed
from ppaas.planners.field.kernels.setup import pad_rows
from ppaas.planners.helper_threads import share
from ppaas.planners.kernels.moves import PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, fixed_weights

SLICE_CELLS = 50_000
"""Cells settled between two checks: about 3 ms."""
SLICE_WALKED = 50_000
"""Cells of a path written between two checks."""
SLICE_READ = 1 << 18
"""Cells whose values are read between two checks: about 3 ms."""
SLICE_SETUP = 1 << 18
"""Cells set up between two checks: 0.04 ms, or 0.15 ms if the memory is newly allocated."""
SLICES_EACH = 4
"""Least number of slices per thread of the set-up; with fewer, no helper is called."""


class _BucketQueue:
    """Ring of buckets, each a linked list of chunks from one pool.

    Parameters
    ----------
    cells : int
        Number of cells to insert before the first call of the kernel.
    """

    def __init__(self, cells: int) -> None:
        chunks = MAX_CHUNKS + 32 + cells // CHUNK + 1
        self.pool = np.empty((chunks, CHUNK), np.uint32)
        self.links = np.arange(1, chunks + 1, dtype=np.int32)
        self.links[-1] = -1
        self.heads = np.full(RING, -1, np.int32)
        self.fills = np.full(RING, CHUNK, np.int32)
        self.state = np.zeros(STATE_SIZE, np.int64)
        self.state[SPARE] = chunks

    def grow(self, check: Callable[[], None]) -> None:
        """Double the pool; the queued cells remain in it."""
        chunks = len(self.pool)
        self.pool = doubled(self.pool, check)
        added = np.arange(chunks + 1, 2 * chunks + 1, dtype=np.int32)
        added[-1] = self.state[FREE]
        self.links = np.concatenate((self.links, added))
        self.state[FREE] = chunks
        self.state[SPARE] += chunks


class QueueField(GridField):
    """Padded costs of a map and a value for each of its cells, which grow from the goals outward.

    Paths may have any length: when values exceed 32 bits, the field continues with 64.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    goals : (n, 2) array
        Row, column of free cells on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    threads : int
        Maximum number of threads; used for the set-up only.
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
        self._check = check
        self._shape = costmap.info.height + 2, costmap.info.width + 2
        self._weights = fixed_weights()
        self._limit = int(UNREACHED) - 1
        self._bound: int | None = None
        costs, field = np.empty(self._shape, np.uint8), np.empty(self._shape, np.uint32)
        slices = self._row_slices()

        def pad_slice(rows: tuple[int, int]) -> None:
            pad_rows(costmap.data, allow_unknown, costs, field, *rows)

        share(slices, pad_slice, helpers=min(threads, len(slices) // SLICES_EACH) - 1, check=check)
        self._costs = costs.ravel()
        self._field: NDArray[np.uint32] | NDArray[np.int64] = field.ravel()
        self._queue = _BucketQueue(len(goals))
        flat = (goals[:, 0].astype(np.int64) + 1) * self._shape[1] + goals[:, 1] + 1
        q = self._queue
        seed(self._field, flat, q.pool, q.links, q.heads, q.fills, q.state)

    @property
    def settled(self) -> int:
        """Number of cells with their final value, without those that cost more than the last target."""
        most = int(self._unreached) - 1 if self._bound is None else self._bound
        count, rows = 0, self._field.reshape(self._shape)
        for first, last in self._row_slices():
            self._check()
            values = rows[first:last]
            count += int(np.count_nonzero((values != BLOCKED) & (values <= most)))
        return count

    def grow(self, target: Cell | None = None) -> bool:
        """Grow the field until the value of ``target`` is final, or over the whole map.

        Returns
        -------
        bool
            Whether ``target`` can be reached; true without a target.
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
        # Each move costs `NEUTRAL` at least, which bounds the number of cells.
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
        """Return the (height, width) costs-to-go; infinite if blocked or not reached."""
        values, inner = np.empty((self._shape[0] - 2, self._shape[1] - 2)), self._field.reshape(self._shape)[1:-1, 1:-1]
        rows = max(1, SLICE_READ // self._shape[1])
        for first in range(0, len(values), rows):
            self._check()
            values[first : first + rows] = self._costs_to_go(inner[first : first + rows])
        return values

    def values_at(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n,) costs-to-go of (n, 2) cells, row and column; infinite if blocked or not reached."""
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
        rows = max(1, SLICE_SETUP // self._shape[1])
        return [(first, min(first + rows, self._shape[0])) for first in range(0, self._shape[0], rows)]

    def _widen(self) -> None:
        """Convert the values to 64 bits: the next ones may not fit 32."""
        narrow = self._field.reshape(self._shape)
        wide = np.empty(self._shape, np.int64)
        for first, last in self._row_slices():
            self._check()
            wide[first:last] = narrow[first:last]
            wide[first:last][narrow[first:last] == UNREACHED] = UNREACHED_WIDE
        self._field = wide.ravel()
        self._limit = int(UNREACHED_WIDE) - (RING << BUCKET_SHIFT)
