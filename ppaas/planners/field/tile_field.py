"""Cost field grown tile by tile, on several threads."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell
from ppaas.planners.field import tile_memory
from ppaas.planners.field.base import GridField
from ppaas.planners.field.kernels.propagation import TOO_NARROW
from ppaas.planners.field.kernels.tile_growth import OUT_OF_WORK, SOON, grow_tiles, seed_tiles
from ppaas.planners.field.kernels.tile_help import wait_briefly
from ppaas.planners.field.kernels.tile_layout import CELLS, SIDE, TOUCHED, UNREACHED
from ppaas.planners.field.kernels.tile_setup import fill_sample
from ppaas.planners.field.kernels.tile_walk import count_up_to, descend_tiles, read_rows
from ppaas.planners.field.tile_helpers import boxes_for
from ppaas.planners.helper_threads import share
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, fixed_weights

SLICE_LINES = 150_000
"""Lines of tiles processed between two checks: 2 to 3 ms on one thread."""
SLICE_ALONE = SOON
"""Lines of the first slice, which runs without helpers: waking helpers costs more than the 0.1 ms that it takes, and
far more if no core is idle."""
SLICE_ALONE_OF_FEW, FEW = 25_000, 256
"""Lines of the first slice on a map of at most `FEW` tiles: the rest after 0.1 ms is not worth waking helpers."""
AT_ONCE = 160
"""Number of tiles from which helpers are called at once if the whole map is to be reached: one thread needs 0.1 ms for
that even on an empty map."""
SLICE_WALKED = 50_000
"""Cells of a path written between two checks."""
SLICE_READ = 128
"""Tiles read between two checks: 130,000 cells, about 1 ms if they are written to newly allocated memory."""
SLICES_EACH = 16
"""Least number of slices per thread when reading: about 0.3 ms."""

MAX_PADDING = 1.5
"""Largest ratio of the cells of all tiles to the cells of the map, on maps larger than `SMALL`."""
SMALL = 1 << 16
"""Number of cells of tiles up to which padding does not matter."""

WINDING = 9
"""A map counts as winding corridors if fewer than one in `WINDING` of its free cells is a fork: a cell with at least
three free cardinal neighbours. In a maze that is a random spanning tree one in 7 is, in one dug depth first one in 11.
"""
SAMPLED = 256
"""Approximate number of tiles sampled for that ratio."""
CLEARLY, GLANCED = 4, 16
"""If more than one in `CLEARLY` free cells of a first sample of `GLANCED` tiles is a fork, the map is not winding. That
decides most maps."""


class PathTooLong(Exception):
    """Values may exceed the 32-bit range of a tile."""


def suits_tiles(shape: tuple[int, int]) -> bool:
    """Return whether a map of this height and width can be cut into tiles without much padding."""
    padded = -(-shape[0] // SIDE) * -(-shape[1] // SIDE) * CELLS
    return padded <= max(SMALL, MAX_PADDING * shape[0] * shape[1])


class TileField(GridField):
    """Cost field in tiles of 32×32 cells.

    Parameters
    ----------
    costmap, goals, allow_unknown, threads, check
        As in `ppaas.planners.field.cost_field.CostField`.
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
        self._check, self._threads = check, threads
        self._shape = costmap.info.shape
        self._source = np.ascontiguousarray(costmap.data).reshape(-1)
        self._source.flags.writeable = False  # a read-only view, for which the kernels are compiled
        self._across = -(-self._shape[1] // SIDE)
        self._tiles = -(-self._shape[0] // SIDE) * self._across
        self._bound: int | None = None
        self._memory = m = tile_memory.acquire(self._tiles)
        self._loan = tile_memory.Loan(m, self._source)
        shape = self._tiles // self._across, self._across
        knows = m.begin(self._source, shape, threads, costmap, allow_unknown)
        seed_tiles(m.record, knows, goals.astype(np.int64, order="C"))

    @property
    def is_winding(self) -> bool:
        """Whether the map consists of corridors one cell wide that rarely fork, on which a queue is faster."""
        free, forks = self._sampled(GLANCED)
        if forks * CLEARLY > free:
            return False
        free, forks = self._sampled(SAMPLED)
        return forks * WINDING < free

    def _sampled(self, count: int) -> tuple[int, int]:
        """Return the number of free cells of about ``count`` tiles, and how many of them are forks."""
        free, forks = fill_sample(self._memory.record, -(-self._tiles // count))
        return int(free), int(forks)

    @property
    def settled(self) -> int:
        """Number of cells with their final value, without those that cost more than the last target."""
        bound = UNREACHED - 1 if self._bound is None else self._bound
        slices, counts, m = self._slices(self._tiles), list[int](), self._memory

        def count(tiles: tuple[int, int]) -> None:
            counts.append(count_up_to(m.field, m.marks, *tiles, bound))

        share(slices, count, helpers=min(self._threads, len(slices) // SLICES_EACH) - 1, check=self._check)
        return sum(counts)

    def grow(self, target: Cell | None = None) -> bool:
        """Grow the field until the value of ``target`` is final, or over the whole map.

        Returns
        -------
        bool
            Whether ``target`` can be reached; true without a target.

        Raises
        ------
        PathTooLong
            Values do not fit 32 bits; use a `QueueField`.
        """
        wanted = -1 if target is None else int(self._elements(np.array([target]))[0])
        outcome = self._run(wanted)
        if outcome == TOO_NARROW:
            raise PathTooLong
        reached = target is None or self._value(wanted) < UNREACHED
        if outcome == EXHAUSTED:
            self._bound = None
        elif reached:
            self._bound = max(self._value(wanted), self._bound or 0)
        return reached

    def _run(self, wanted: int) -> int:
        """Call the kernel slice by slice, with helpers, until it ends; return why it did."""
        memory = self._memory
        boxes, budget = boxes_for(1), SLICE_ALONE if self._tiles > FEW else SLICE_ALONE_OF_FEW
        if wanted < 0 and self._tiles >= AT_ONCE:
            boxes, budget = boxes_for(self._threads), SLICE_LINES
        memory.open_for_help(wanted)
        try:
            while True:
                self._check()
                outcome = grow_tiles(memory.record, boxes, 0, budget)
                if outcome == OUT_OF_WORK:
                    wait_briefly()
                elif outcome != PAUSED:
                    return int(outcome)
                boxes, budget = boxes_for(self._threads), SLICE_LINES
        finally:
            memory.close_for_help(boxes)

    def path_from(self, cell: Cell) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path from ``cell``, whose value must be final, to a goal."""
        # Each move costs `NEUTRAL` at least, which bounds the number of cells.
        most = self._value(int(self._elements(np.array([cell]))[0])) // round(SCALE * NEUTRAL) + 1
        cells = np.empty((most, 2), np.int32)
        cells[0] = cell
        count, before = 1, 0
        while count > before:
            self._check()
            before = count
            count = descend_tiles(
                self._memory.field, self._memory.tables, self._memory.marks, self._source, *self._shape,
                self._across, fixed_weights(), cells, count, min(SLICE_WALKED, most - count),
            )  # fmt: skip
        return cells[:count].copy()

    def values(self) -> NDArray[np.float64]:
        """Return the (height, width) costs-to-go; infinite if blocked or not reached."""
        values = np.empty(self._shape)
        for first, last in self._slices(self._tiles // self._across, self._across):
            self._check()
            end = min(last * SIDE, self._shape[0])
            read_rows(self._memory.field, self._memory.marks, self._across, first * SIDE, end, SCALE, values)
        return values

    def values_at(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n,) costs-to-go of (n, 2) cells, row and column; infinite if blocked or not reached."""
        elements = self._elements(cells)
        values = self._memory.field[elements]
        reached = (values < UNREACHED) & (self._memory.marks[elements // CELLS] & TOUCHED != 0)
        return np.where(reached, values / SCALE, np.inf)

    def _value(self, element: int) -> int:
        touched = self._memory.marks[element // CELLS] & TOUCHED
        return int(self._memory.field[element]) if touched else UNREACHED

    def _elements(self, cells: NDArray[np.integer]) -> NDArray[np.int64]:
        row, column = cells[:, 0].astype(np.int64), cells[:, 1].astype(np.int64)
        tile = row // SIDE * self._across + column // SIDE
        return tile * CELLS + row % SIDE * SIDE + column % SIDE

    def _slices(self, count: int, tiles_each: int = 1) -> list[tuple[int, int]]:
        step = max(1, SLICE_READ // tiles_each)
        return [(first, min(first + step, count)) for first in range(0, count, step)]
