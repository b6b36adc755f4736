"""A field of costs-to-go that is grown only as far as one cell needs it: A*."""

from collections.abc import Callable

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell
from ppaas.planners.grid_field import GridField
from ppaas.planners.kernels.aiming import COUNT, SIZE, STATE_SIZE, aim
from ppaas.planners.kernels.layout import AT_GOAL
from ppaas.planners.kernels.propagation import PAUSED, POOL_EMPTY, SETTLED, TOO_NARROW
from ppaas.planners.watch import proceed

SLICE_CELLS = 10_000
"""Cells settled between two checks: about 3 ms."""

FIRST_ROOM = 1 << 12
"""Entries that the heap has room for to begin with."""


class AimedField(GridField):
    """A field that grows from its goal towards a target, in slices.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    goal, target : (row, column)
        Free cells on the map.
    allow_unknown, threads, check
        As in `GridField`.
    """

    def __init__(
        self,
        costmap: Costmap,
        goal: Cell,
        target: Cell,
        *,
        allow_unknown: bool = True,
        threads: int = 1,
        check: Callable[[], None] = proceed,
    ) -> None:
        super().__init__(costmap, allow_unknown=allow_unknown, threads=threads, check=check)
        self._target = self._flat(target)
        self._least = self._weights[:, 0].copy()
        self._keys = np.zeros(FIRST_ROOM, np.int64)
        self._cells = np.empty(FIRST_ROOM, np.uint32)
        self._state = np.zeros(STATE_SIZE, np.int64)
        self._field[self._flat(goal)] = AT_GOAL
        # The lowest key there is, so that it is never taken for one whose value fell since.
        self._cells[0], self._state[SIZE] = self._flat(goal), 1

    @property
    def settled(self) -> int:
        """How many cells have their final value; the target is not counted."""
        return int(self._state[COUNT])

    def grow(self) -> bool:
        """Let it grow until the value of the target is final; return whether it can be reached."""
        while True:
            self._check()
            outcome = aim(
                self._field, self._costs, self._shape[1], self._weights, self._least,
                self._keys, self._cells, self._state, self._target, self._limit, SLICE_CELLS,
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                self._keys = np.concatenate((self._keys, np.empty_like(self._keys)))
                self._cells = np.concatenate((self._cells, np.empty_like(self._cells)))
            elif outcome == TOO_NARROW:
                self._widen()
            elif outcome != PAUSED:
                return bool(outcome == SETTLED)
