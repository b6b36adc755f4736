"""Lifelong plan of a fleet: it is extended step by step, and robots get new goals meanwhile."""

import contextlib
import itertools
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import NoValidPath, PlanTimeout
from ppaas.fleet.configuration_search import ConfigurationSearch
from ppaas.fleet.kernels.board import NO_GUIDE, NOBODY, UNREACHABLE, step_of
from ppaas.fleet.kernels.pibt import decide
from ppaas.fleet.problem import board_of, check_distinct, distances_from
from ppaas.fleet.roadmap import Roadmap

PATIENCE = 20
"""Number of steps that a goal may be open beyond twice the length of the way before the robot is helped."""

TRIES = 20
"""Number of slices of some 10 ms that a search for it may take."""


class LifelongPlan:
    """Conflict-free steps of robots whose goals change.

    A plan that is only ever extended breaks nothing off: robots that are about to exchange their places in a lane
    finish that. The robot whose goal is open for the longest time decides first. If its goal is open much longer than
    its way is, robots circle around each other; then a search finds steps after which it is at its goal.

    Parameters
    ----------
    roadmap : Roadmap
    starts : (n,) int32 array
        Cells of the robots, all different. They have no goals and give way, until `set_goal`.
    seed : int
        Seed of the random numbers.

    Raises
    ------
    InvalidInput
        Two robots start in one cell.
    """

    def __init__(self, roadmap: Roadmap, starts: NDArray[np.int32], seed: int = 0) -> None:
        check_distinct(starts, roadmap, "starts")
        self._roadmap = roadmap
        distances = np.empty((len(starts), len(roadmap)), np.int16)
        self._board = board_of(roadmap, distances, NO_GUIDE, starts.astype(np.int32))
        self._step = step_of(self._board, starts, seed)
        self._ages = np.random.default_rng(seed).random(len(starts)).astype(np.float32)
        self._seed = seed
        self._patience = np.zeros(len(starts), np.int64)
        self._found: deque[NDArray[np.int32]] = deque()
        for robot, cell in enumerate(starts):
            self.set_goal(robot, int(cell))

    @property
    def cells(self) -> NDArray[np.int32]:
        """Cell of each robot after the last step, (n,) int32."""
        return self._step.at.copy()

    @property
    def goals(self) -> NDArray[np.int32]:
        """Goal of each robot, (n,) int32."""
        return self._board.goals.copy()

    @property
    def ages(self) -> NDArray[np.int64]:
        """Number of steps for which each robot's goal has been open, (n,) int64."""
        return self._ages.astype(np.int64)

    def can_reach(self, robot: int) -> bool:
        """Return whether there is a way from a robot's cell to its goal."""
        return bool(self._board.distances[robot, self._step.at[robot]] < UNREACHABLE)

    def set_goal(self, robot: int, cell: int) -> None:
        """Give a robot a new goal.

        Raises
        ------
        InvalidInput
            The map is too large (``distances_from``).
        """
        self._board.goals[robot] = cell
        self._ages[robot] %= 1.0
        self._board.distances[robot] = distances_from(self._roadmap, np.array([cell], np.int32))[0]
        self._patience[robot] = PATIENCE + 2 * int(self._board.distances[robot, self._step.at[robot]])

    def extend(self, waiting: NDArray[np.bool_] | None = None) -> NDArray[np.int32]:
        """Plan one more step; return the cell of each robot after it, (n,) int32.

        Parameters
        ----------
        waiting : (n,) bool array, optional
            True for robots that stay in this step because they are behind the plan. Steps that a search has found for a
            robot that waited too long move them all the same.
        """
        if not self._found:
            self._help_oldest()
        step, ages = self._step, self._ages
        ages[:] = np.where(step.at == self._board.goals, ages % 1.0, ages + 1.0)
        if self._found:
            step.at[:] = self._found.popleft()
        else:
            step.to[:] = NOBODY if waiting is None else np.where(waiting, step.at, NOBODY)
            decide(self._board, step, np.argsort(-ages))
            step.at[:] = step.to
        return self.cells

    def _help_oldest(self) -> None:
        """Search steps that bring the robot to its goal that has waited longest for it, if that is too long."""
        oldest = int(np.argmax(self._ages))
        if self._ages[oldest] < self._patience[oldest] or not self.can_reach(oldest):
            return
        required = np.arange(len(self._ages)) == oldest
        self._seed += 1
        tries = itertools.count()

        def check() -> None:
            if next(tries) >= TRIES:
                raise PlanTimeout("no steps were found in time")

        self._patience[oldest] += PATIENCE
        with contextlib.suppress(NoValidPath, PlanTimeout):  # it waits on, and others may clear the way
            self._found.extend(ConfigurationSearch(self._board, self.cells, required, self._seed).run(check)[1:])
