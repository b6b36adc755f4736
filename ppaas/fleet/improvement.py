"""Improvement of a plan by large neighbourhood search, for as long as it may take."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import seeded
from ppaas.fleet.kernels.neighbourhood import improve_some, memory_of
from ppaas.fleet.kernels.timed_search import Schedule, mark
from ppaas.fleet.kernels.turning_search import Prices
from ppaas.fleet.plan import FleetPlan, turns_of
from ppaas.fleet.problem import FleetProblem

GROUP = 4
"""Largest number of robots that are replanned together. Larger groups are worse where robots are dense."""

PLAIN = 0.8
"""Part of the time in which turns cost nothing at first: searches without them are faster, and so plans of many robots
become better sooner."""

AT_ONCE = 20
"""Number of groups between two looks at the clock."""

PARTS, MOST_TURN = 10, 20.0
"""Costs are rounded to such a part of a step, if turns cost something; largest cost of a quarter turn [steps]."""


class Improvement:
    """A plan that becomes better.

    Parameters
    ----------
    problem : FleetProblem
    plan : FleetPlan
        A valid plan.
    seed : int
        Seed of the random numbers.
    turn : float
        Cost of a quarter turn [steps]; one of more than `MOST_TURN` counts as so much.
    """

    def __init__(self, problem: FleetProblem, plan: FleetPlan, seed: int = 0, turn: float = 0.0) -> None:
        self._problem = problem
        paths = np.ascontiguousarray(plan.steps.T)
        steps, cells = len(plan.steps), len(problem.roadmap)
        self._prices = _prices_of(problem, turn)
        turns = turns_of(problem.roadmap, plan) if self._prices.quarter else np.zeros(len(problem), np.int32)
        self._schedule = Schedule(np.zeros((steps, cells), np.int32), paths, plan.arrivals.astype(np.int32), turns)
        for robot in range(len(problem)):
            mark(self._schedule, robot, robot + 1)
        self._memory = memory_of(steps, cells, GROUP, self._prices)
        self._bits, self._random = seeded(seed), np.random.default_rng(seed)
        self._number = 1

    def plan(self) -> FleetPlan:
        """Return the plan as it is now."""
        last = int(self._schedule.arrivals.max(initial=0))
        return FleetPlan(np.ascontiguousarray(self._schedule.paths[:, : last + 1].T), self._problem.bound)

    @property
    def cost(self) -> float:
        """Sum of the arrivals, and of the costs of all turns [steps]."""
        return int(self._costs.sum()) / self._prices.step

    @property
    def _costs(self) -> NDArray[np.int64]:
        prices, schedule = self._prices, self._schedule
        return prices.step * schedule.arrivals.astype(np.int64) + prices.quarter * schedule.turns

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Improve the plan while ``goes_on`` returns True, which is asked every few milliseconds.

        Returns earlier if no plan is better, and at once without robots, or if areas have room for few: it does not
        count these.
        """
        if self._problem.roadmap.room.size or not len(self._problem):
            return
        board, bound = self._problem.board(), self._prices.least.sum()
        for firsts, alone in self._tries():
            if not goes_on() or self._costs.sum() == bound:
                return
            improve_some(
                board, self._problem.starts, self._schedule, self._memory, self._prices,
                firsts, alone, self._number, self._bits,
            )  # fmt: skip
            self._number += len(firsts) * GROUP

    def _tries(self) -> Iterator[tuple[NDArray[np.int32], bool]]:
        """Yield robots to replan: first each alone, the dearest first, then groups around robots by their delays."""
        dearest = np.argsort(self._prices.least - self._costs, kind="stable").astype(np.int32)
        for begin in range(0, len(dearest), AT_ONCE):
            yield dearest[begin : begin + AT_ONCE], True
        while True:
            late = (self._costs - self._prices.least).astype(np.float64)
            chances = late / late.sum() if late.any() else None
            yield self._random.choice(len(late), AT_ONCE, p=chances).astype(np.int32), False


def _prices_of(problem: FleetProblem, turn: float) -> Prices:
    """Return the costs of paths, for a cost of a quarter turn [steps]."""
    quarter = round(PARTS * min(turn, MOST_TURN))
    step, cells = PARTS if quarter else 1, problem.roadmap.cells
    turns = (cells[problem.starts] != cells[problem.goals]).all(axis=1)  # a way in both directions has at least one
    return Prices(step, quarter, step * problem.least + quarter * turns, cells)


def improved(
    problem: FleetProblem, plan: FleetPlan, seed: int, turn: float, passed: Callable[[], float]
) -> Improvement:
    """Return the improvement of a plan after all of a time has passed.

    Parameters
    ----------
    problem, plan, seed, turn
        As of `Improvement`.
    passed : callable
        Returns the part of the time that has passed, and is asked every few milliseconds; ends the work by raising.
    """
    improvement = Improvement(problem, plan, seed)
    improvement.run(lambda: passed() < (PLAIN if turn else 1.0))
    if turn:
        improvement = Improvement(problem, improvement.plan(), seed, turn)
        improvement.run(lambda: passed() < 1.0)
    return improvement
