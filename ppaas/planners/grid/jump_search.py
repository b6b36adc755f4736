"""Jump point search on a prepared map."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.ends import Cell
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.bucket_ring import BucketRing
from ppaas.planners.grid.jump_map import JumpMap
from ppaas.planners.grid.kernels.jps import COUNT, EXTRA_STATE, LONGEST, jump, unwind
from ppaas.planners.grid.reusable_values import ReusableValues
from ppaas.planners.kernels.moves import PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.prepared import Prepared
from ppaas.planners.watch import proceed

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
