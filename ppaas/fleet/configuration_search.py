"""Search in the configurations of all robots, which grows its memory and can be ended."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import NoValidPath
from ppaas.fleet.kernels import lacam
from ppaas.fleet.kernels.board import Board, Ints, step_of
from ppaas.planners.array_growth import doubled

BUDGET = 2_000_000
"""Number of decisions of robots between two checks: some 10 ms."""

FIRST_NODES, FIRST_TABLE, FIRST_CONSTRAINTS = 256, 1024, 2048


class ConfigurationSearch:
    """Search of LaCAM for steps of all robots until some of them are at their goals; its memory grows as needed.

    Parameters
    ----------
    board : Board
    starts : (n,) int32 array
        Cells of the robots, at least one.
    required : (n,) bool array
        True for robots that must be at their goals at the end; the others go towards theirs meanwhile.
    seed : int
        Seed of the random numbers.
    """

    def __init__(self, board: Board, starts: Ints, required: NDArray[np.bool_], seed: int) -> None:
        n = len(starts)
        self._board = board
        self._step = step_of(board, starts, seed)
        self._step.to[:] = starts
        self._budget = max(1, BUDGET // n)
        self._search = lacam.Search(
            np.empty((FIRST_NODES, n), np.int32),
            np.empty((FIRST_NODES, n), np.float32),
            np.empty((FIRST_NODES, 3), np.int32),
            np.empty((FIRST_CONSTRAINTS, 5), np.int32),
            np.empty(FIRST_NODES, np.int32),
            np.full(FIRST_TABLE, -1, np.int32),
            np.random.default_rng(seed).integers(1, 1 << 62, n, np.uint64) | np.uint64(1),
            np.zeros(n, np.int64),
            required,
            np.array([0, 0, 0, -1, 1], np.int64),
        )

    def run(self, check: Callable[[], None]) -> Ints:
        """Return the cells of all robots after each step, (t, n) int32; the first row are the starts.

        Parameters
        ----------
        check : callable
            Called every few milliseconds; ends the search by raising.

        Raises
        ------
        NoValidPath
            There is no plan: the robots cannot pass each other.
        """
        while True:
            check()
            found = lacam.explore(self._board, self._step, self._search, self._budget)
            if found == lacam.FOUND:
                return self._plan()
            if found == lacam.EXHAUSTED:
                raise NoValidPath("there is no plan: the robots cannot pass each other")
            if found == lacam.FULL:
                self._grow(check)

    def _plan(self) -> Ints:
        chain = [int(self._search.state[lacam.CURRENT])]
        while (parent := int(self._search.nodes[chain[-1], lacam.PARENT])) >= 0:
            chain.append(parent)
        return self._search.cells[chain[::-1]]

    def _grow(self, check: Callable[[], None]) -> None:
        search, state = self._search, self._search.state
        if state[lacam.NODES] == len(search.nodes):
            more = {name: doubled(getattr(search, name), check) for name in ("cells", "ages", "nodes")}
            search = search._replace(**more)
        if state[lacam.HEIGHT] == len(search.stack):
            search = search._replace(stack=doubled(search.stack, check))
        if state[lacam.CONSTRAINTS] + lacam.BRANCHES > len(search.constraints):
            search = search._replace(constraints=doubled(search.constraints, check))
        if 2 * state[lacam.NODES] >= len(search.table):
            search = search._replace(table=np.full(2 * len(search.table), -1, np.int32))
            lacam.fill_table(search)
        self._search = search
