"""First plan of a fleet, by LaCAM; guided where robots are dense."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.configuration_search import ConfigurationSearch
from ppaas.fleet.kernels import guides
from ppaas.fleet.kernels.board import NO_GUIDE, seeded, shuffle
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import FleetProblem
from ppaas.planners.watch import proceed

DENSE = 0.1
"""Robots for each cell from which guides shorten the plan."""

AGAINST, CROWD = 5, 1
"""Costs of traffic (`ppaas.fleet.kernels.guides`)."""

BUDGET = 2_000_000
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
    at_once = max(1, BUDGET // max(1, len(problem.roadmap)))
    for begin in range(0, len(robots), at_once):
        check()
        some = robots[begin : begin + at_once]
        guides.guide_some(board, traffic, problem.starts, some, AGAINST, CROWD, begin + 1)
    return guide
