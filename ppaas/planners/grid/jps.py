"""Jump point search: paths of the same cost as A*, with few expanded cells, on a map prepared once."""

import math
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell, Ends
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.grid.kernels.jps import COUNT, EXTRA_STATE, LONGEST, jump, unwind
from ppaas.planners.grid.kernels.jump_planes import mark_cells, mark_jumps, turn
from ppaas.planners.grid.padded_map import PaddedMap
from ppaas.planners.grid.search_memory import BucketRing, ReusableValues
from ppaas.planners.grid_planner import Found
from ppaas.planners.kernels.moves import PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.prepared import Prepared, PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed

# -- preparation of a map ----------------------------------------------------------------------------------------------

PLANES = 5
"""Number of bit planes; see `ppaas.planners.grid.kernels.jump_planes`."""

SLICE_MARKED = 1 << 19
"""Cells whose bits are set between two checks: about 3 ms."""


class JumpMap:
    """Padded map, and bit planes of the ends of jumps along its rows and columns.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.

    Attributes
    ----------
    costmap : Costmap
    allow_unknown : bool
    padded : PaddedMap
    rows, columns : (5, lines, words) uint64 array
        The bit planes, as in `ppaas.planners.grid.kernels.jump_planes`.
    """

    def __init__(self, costmap: Costmap, *, allow_unknown: bool = True, check: Callable[[], None] = proceed) -> None:
        self.costmap, self.allow_unknown = costmap, allow_unknown
        self.padded = PaddedMap(costmap, allow_unknown=allow_unknown, check=check)
        height, width = self.padded.shape
        words = width // 64, -(-height // 64)
        split = PLANES * height * words[0]
        self.planes = np.zeros(split + PLANES * width * words[1], np.uint64)
        self.rows = self.planes[:split].reshape(PLANES, height, words[0])
        self.columns = self.planes[split:].reshape(PLANES, width, words[1])
        costs = self.padded.costs.reshape(self.padded.shape)
        weights, one_cost = self.padded.weights[0], self.padded.one_cost
        for first, last in _slices(height, width):
            check()
            mark_cells(costs, weights, one_cost, self.rows, first, last)
        for word in range(self.columns.shape[2]):
            check()
            turn(self.rows, self.columns, word, word + 1)
        for planes in (self.rows, self.columns):
            for first, last in _slices(planes.shape[1], 64 * planes.shape[2]):
                check()
                mark_jumps(planes, first, last)

    def query(self, base: int, target: int) -> tuple[int, ...]:
        """Return the ``query`` argument of the kernel `ppaas.planners.grid.kernels.jps`."""
        height, stride = self.padded.shape
        column = 64 * self.columns.shape[2]
        return (
            base, *divmod(target, stride), stride, self.padded.least,
            height * stride, 64 * self.rows.size, column, column * stride,
        )  # fmt: skip

    @property
    def nbytes(self) -> int:
        """Memory used [bytes]."""
        return self.padded.nbytes + self.planes.nbytes


def _slices(lines: int, length: int) -> list[tuple[int, int]]:
    at_once = max(1, SLICE_MARKED // length)
    return [(first, min(first + at_once, lines)) for first in range(0, lines, at_once)]


# -- search on a prepared map ------------------------------------------------------------------------------------------

SLICE_WORK = 20_000
"""Words of the bit planes scanned between two checks: 0.5 ms, or a few if the memory is newly allocated."""

SLICE_UNWOUND = 1 << 17
"""Cells of a path written between two checks: about 1 ms."""

FIRST_CELLS = 4096
"""Initial capacity of the path [cells]."""

LARGE = 256 * 256
"""Cells of a map above which a cost field takes over searches that are long for the map."""

CELLS_PER_WORD = 24
"""Cells of a large map for each word that a search may scan first: it takes a third of the time of a cost field over
the whole map, which does not grow with the number of corners."""

AFTER_A_LONG_ONE = 8
"""Part of that work which a search may do where the one before was too long: on such a map most are."""


class JumpSearch(Prepared):
    """Search for cheapest paths by jumps; on a large map with many corners, a cost field takes over.

    Parameters
    ----------
    jump_map : JumpMap
        Only read.

    Attributes
    ----------
    taken_over : bool
        Whether a cost field found the last path.
    """

    def __init__(self, jump_map: JumpMap) -> None:
        self._map = jump_map
        padded = jump_map.padded
        side = max(padded.shape)
        self._weights = padded.weights[0].copy()
        self._nodes = ReusableValues((padded.costs.size, 2), padded.path_bound + 2)
        # Queue entries that expanding one cell may add: for each of four diagonal jumps two straight jumps per move and
        # its end, and the four straight jumps of the cell itself.
        self._room = 4 * (2 * min(LONGEST, side) + 1) + 4
        # Span of the keys: a jump is at most as long as the map, and changes the estimate by at most its own weight.
        self._ring = BucketRing(2 * side * padded.most, padded.grain, self._room, EXTRA_STATE)
        self._cells = np.empty((FIRST_CELLS, 2), np.int32)
        self.taken_over = False

    @property
    def nbytes(self) -> int:
        """Memory used in addition to the costmap, if all cells have been touched [bytes]."""
        return self._map.nbytes + self._nodes.values.nbytes + self._ring.nbytes + self._cells.nbytes

    def twin(self) -> "JumpSearch":
        """Return a search for another thread; the map is shared."""
        return JumpSearch(self._map)

    def path(
        self, start_row: int, start_column: int, goal_row: int, goal_column: int, check: Callable[[], None] = proceed
    ) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path; empty if there is no path."""
        flat = self._map.padded.flat
        start = flat((start_row, start_column))
        reached = self._grow(flat((goal_row, goal_column)), start, check)
        self.taken_over = reached is None
        if reached is None:
            return self._by_field((start_row, start_column), (goal_row, goal_column), check)
        self.expanded = int(self._ring.state[COUNT])
        return self._unwound(start, check) if reached else np.empty((0, 2), np.int32)

    def _by_field(self, start: Cell, goal: Cell, check: Callable[[], None]) -> NDArray[np.int32]:
        searched = self._map
        field = CostField(searched.costmap, np.array([goal]), allow_unknown=searched.allow_unknown, check=check)
        reached = field.grow(start)
        self.expanded = field.settled
        return field.path_from(start) if reached else np.empty((0, 2), np.int32)

    def _patience(self) -> float:
        """Return the number of words that the next search may scan."""
        cells = self._map.costmap.data.size
        if cells <= LARGE:
            return math.inf
        return cells / CELLS_PER_WORD / (AFTER_A_LONG_ONE if self.taken_over else 1)

    def _grow(self, goal: int, target: int, check: Callable[[], None]) -> bool | None:
        """Return whether the target is reached; None if the search is too long for the map."""
        ring, padded, planes = self._ring, self._map.padded, self._map.planes
        query = self._map.query(self._nodes.begin(), target)
        ring.state[COUNT] = -1
        left = self._patience()
        while True:
            check()
            outcome = jump(
                planes, padded.costs, self._weights, self._nodes.values,
                ring.heads, ring.marks, ring.pool, ring.state, query, goal, self._room, SLICE_WORK,
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                ring.grow(check)
            elif outcome != PAUSED:
                return bool(outcome == SETTLED)
            left -= SLICE_WORK
            if left < 0.0:
                return None

    def _unwound(self, start: int, check: Callable[[], None]) -> NDArray[np.int32]:
        side = max(self._map.padded.shape)
        node, count = start, 0
        while node >= 0:
            check()
            if len(self._cells) <= count + side:
                self._cells = np.concatenate((self._cells, np.empty((len(self._cells) + side, 2), np.int32)))
            budget = min(SLICE_UNWOUND, len(self._cells) - count - side)
            node, count = unwind(self._nodes.values, self._map.padded.shape[1], node, self._cells, count, budget)
        return self._cells[:count].copy()


# -- the planner -------------------------------------------------------------------------------------------------------


class JumpPointSearch(PreparedPlanner):
    """Jumps over cells where a cheapest path need not turn.

    It is fast on large areas of one cost. Where costs change from cell to cell, it expands single cells; its paths are
    the cheapest there too. Above 256 x 256 cells, a cost field, as of ``dijkstra``, takes over such searches, and all
    those on a writable map, which takes longer to prepare than to search.
    """

    name: ClassVar[str] = "jps"
    purpose: ClassVar[str] = "Cheapest path where large areas have one cost; prepares a map in milliseconds."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> JumpSearch:
        """Precompute the ends of straight jumps."""
        return JumpSearch(JumpMap(costmap, allow_unknown=self.allow_unknown, check=check))

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells between two ends."""
        if costmap.data.flags.writeable and costmap.data.size > LARGE:
            return Dijkstra(allow_unknown=self.allow_unknown).search(costmap, ends, threads=threads, check=check)
        return super().search(costmap, ends, threads=threads, check=check)
