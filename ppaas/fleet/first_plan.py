"""First plan of a fleet, by LaCAM's search in the configurations of all robots; guided where robots are dense."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import NoValidPath
from ppaas.fleet.kernels import guides, lacam
from ppaas.fleet.kernels.board import NO_GUIDE, Board, Ints, seeded, shuffle, step_of
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import FleetProblem
from ppaas.planners.array_growth import doubled
from ppaas.planners.watch import proceed

# -- search in the configurations of all robots, which grows its memory and can be ended -------------------------------

DECISIONS = 2_000_000
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
        self._budget = max(1, DECISIONS // n)
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


# -- first plan --------------------------------------------------------------------------------------------------------

DENSE = 0.1
"""Robots for each cell from which guides shorten the plan."""

AGAINST, CROWD = 5, 1
"""Costs of traffic (`ppaas.fleet.kernels.guides`)."""

# -- first plan --------------------------------------------------------------------------------------------------------

CELLS = 2_000_000
"""Number of cells that searches of ways may visit between two checks: some 10 ms."""


def first_plan(problem: FleetProblem, seed: int = 0, check: Callable[[], None] = proceed) -> FleetPlan:
    """Return a plan.

    Parameters
    ----------
    problem : FleetProblem
    seed : int
        Seed of the random numbers; the same one gives the same plan.
    check : callable
        Called every few milliseconds; ends the work by raising.

    Raises
    ------
    NoValidPath
        There is no plan: the robots cannot pass each other.
    """
    if len(problem) == 0:
        return FleetPlan(np.empty((1, 0), np.int32), 0)
    is_dense = len(problem) > DENSE * len(problem.roadmap)
    guide = guide_of(problem, seed, check) if is_dense else NO_GUIDE
    board, everybody = problem.board(guide), np.ones(len(problem), np.bool_)
    search = ConfigurationSearch(board, problem.starts, everybody, seed)
    return FleetPlan(search.run(check), problem.bound)


def guide_of(problem: FleetProblem, seed: int, check: Callable[[], None] = proceed) -> NDArray[np.int8]:
    """Return the guide of each robot, (n, v) int8 (`ppaas.fleet.kernels.board.Board`)."""
    guide = np.full(problem.distances.shape, -1, np.int8)
    board, traffic = problem.board(guide), guides.traffic_of(problem.roadmap.neighbours)
    robots = np.arange(len(problem), dtype=np.int32)
    shuffle(seeded(seed), robots)
    at_once = max(1, CELLS // max(1, len(problem.roadmap)))
    for begin in range(0, len(robots), at_once):
        check()
        some = robots[begin : begin + at_once]
        guides.guide_some(board, traffic, problem.starts, some, AGAINST, CROWD, begin + 1)
    return guide
