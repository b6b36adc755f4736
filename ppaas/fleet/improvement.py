"""Improvement of a plan by large neighbourhood search, for as long as it may take."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import seeded
from ppaas.fleet.kernels.neighbourhood import improve_some, memory_of
from ppaas.fleet.kernels.timed_search import Schedule, mark
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import FleetProblem

GROUP = 4
"""Largest number of robots that are planned anew together. Larger groups are worse where robots are dense."""

AT_ONCE = 20
"""Number of groups between two looks at the clock."""


class Improvement:
    """A plan that becomes better.

    Parameters
    ----------
    problem : FleetProblem
    plan : FleetPlan
        A valid plan.
    seed : int
        Seed of the random numbers.
    """

    def __init__(self, problem: FleetProblem, plan: FleetPlan, seed: int = 0) -> None:
        self._problem = problem
        paths = np.ascontiguousarray(plan.steps.T)
        steps, cells = len(plan.steps), len(problem.roadmap)
        self._schedule = Schedule(np.zeros((steps, cells), np.int32), paths, plan.arrivals.astype(np.int32))
        for robot in range(len(problem)):
            mark(self._schedule, robot, robot + 1)
        self._memory = memory_of(steps, cells, GROUP)
        self._least = problem.least
        self._bits, self._random = seeded(seed), np.random.default_rng(seed)
        self._number = 1

    def plan(self) -> FleetPlan:
        """Return the plan as it is now."""
        last = int(self._schedule.arrivals.max(initial=0))
        return FleetPlan(np.ascontiguousarray(self._schedule.paths[:, : last + 1].T), self._problem.bound)

    @property
    def cost(self) -> int:
        """Sum of the arrivals."""
        return int(self._schedule.arrivals.astype(np.int64).sum())

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Improve the plan while ``goes_on`` returns True, which is asked every few milliseconds.

        Returns earlier if no plan is better, and at once if areas have room for few robots: it does not count these.
        """
        if self._problem.roadmap.room.size:
            return
        board, bound = self._problem.board(), self._problem.bound
        for firsts, alone in self._tries():
            if not goes_on() or self.cost == bound:
                return
            improve_some(
                board, self._problem.starts, self._schedule, self._memory,
                firsts, alone, self._number, self._bits,
            )  # fmt: skip
            self._number += len(firsts) * GROUP

    def _tries(self) -> Iterator[tuple[NDArray[np.int32], bool]]:
        """Yield robots to plan anew: first each alone, the latest first, then groups around robots by their delays."""
        latest = np.argsort(self._least - self._schedule.arrivals, kind="stable").astype(np.int32)
        for begin in range(0, len(latest), AT_ONCE):
            yield latest[begin : begin + AT_ONCE], True
        while True:
            late = (self._schedule.arrivals - self._least).astype(np.float64)
            chances = late / late.sum() if late.any() else None
            yield self._random.choice(len(late), AT_ONCE, p=chances).astype(np.int32), False
