"""Lifelong plan of a fleet: it is extended step by step, and robots get new goals meanwhile."""

import contextlib
import itertools
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import NoValidPath, PlanTimeout
from ppaas.fleet.first_plan import ConfigurationSearch
from ppaas.fleet.kernels.board import NO_GUIDE, NOBODY, UNREACHABLE, step_of
from ppaas.fleet.kernels.pibt import decide
from ppaas.fleet.problem import board_of, check_distinct, distances_from
from ppaas.fleet.roadmap import Roadmap

PATIENCE = 20
"""Number of steps that a goal may be open beyond twice the length of the way before the robot is helped."""

STALLED = 8
"""Number of steps without getting nearer to its goal after which a robot is helped, where areas have room for few.

There, who waits for room and who would make it may push each other to and fro.
"""

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
    sizes : (n,) int8 array, optional
        Size of each robot, a row of ``roadmap.barred``. A robot may start in a cell that its size does not enter.

    Raises
    ------
    InvalidInput
        Two robots start in one cell.
    """

    def __init__(
        self, roadmap: Roadmap, starts: NDArray[np.int32], seed: int = 0, sizes: NDArray[np.int8] | None = None
    ) -> None:
        check_distinct(starts, roadmap, "starts")
        self._roadmap = roadmap
        distances = np.empty((len(starts), len(roadmap)), np.int16)
        self._sizes = sizes if len(roadmap.barred) else None
        self._of_size: dict[int, Roadmap] = {}
        self._board = board_of(roadmap, distances, NO_GUIDE, starts.astype(np.int32), self._sizes)
        self._step = step_of(self._board, starts, seed)
        self._ages = np.random.default_rng(seed).random(len(starts)).astype(np.float32)
        self._seed = seed
        self._patience = np.zeros(len(starts), np.int64)
        self._nearest = np.zeros(len(starts), np.int16)
        self._found: deque[NDArray[np.int32]] = deque()
        for robot, cell in enumerate(starts):
            self.set_goal(robot, int(cell))

    @property
    def cells(self) -> NDArray[np.int32]:
        """Cell of each robot after the last step, (n,) int32."""
        return self._step.at.copy()

    @property
    def sought_areas(self) -> set[int]:
        """Areas without room to which robots are next on their shortest ways."""
        board, at = self._board, self._step.at
        if not len(board.room):
            return set()
        near = board.neighbours[at]
        apart = np.where(near >= 0, np.take_along_axis(board.distances, near, axis=1), UNREACHABLE)
        best = apart.argmin(axis=1)
        moves = np.take_along_axis(apart, best[:, np.newaxis], axis=1)[:, 0] < board.distances[np.arange(len(at)), at]
        sought = board.areas[near[np.arange(len(at)), best]] & ~board.areas[at]
        wanted = np.bitwise_or.reduce(sought[moves], initial=np.uint64(0))
        full = [area for area, room in enumerate(board.room.tolist()) if self._inside(area).sum() >= room]
        return {area for area in full if int(wanted) >> area & 1}

    def _inside(self, area: int) -> NDArray[np.bool_]:
        return (self._board.areas[self._step.at] >> np.uint64(area) & np.uint64(1)).astype(np.bool_)

    @property
    def goals(self) -> NDArray[np.int32]:
        """Goal of each robot, (n,) int32."""
        return self._board.goals.copy()

    @property
    def ages(self) -> NDArray[np.int64]:
        """Number of steps for which each robot's goal has been open, (n,) int64."""
        return self._ages.astype(np.int64)

    def roadmap_of(self, robot: int) -> Roadmap:
        """Return the roadmap without the moves into cells that a robot does not enter."""
        if self._sizes is None:
            return self._roadmap
        size = int(self._sizes[robot])
        if size not in self._of_size:
            self._of_size[size] = self._roadmap.for_size(size)
        return self._of_size[size]

    def can_reach(self, robot: int) -> bool:
        """Return whether there is a way from a robot's cell to its goal."""
        return bool(self._board.distances[robot, self._step.at[robot]] < UNREACHABLE)

    def set_goal(self, robot: int, cell: int, age: int = 0, size: int | None = None) -> None:
        """Give a robot a new goal.

        Parameters
        ----------
        robot, cell : int
        age : int
            Number of steps for which it has been open already, in another plan.
        size : int, optional
            Row of ``roadmap.barred`` that holds for the robot from now on; by default the one before.

        Raises
        ------
        InvalidInput
            The map is too large (``distances_from``).
        """
        if size is not None:
            self.set_size(robot, size)
        self._board.goals[robot] = cell
        self._ages[robot] = self._ages[robot] % 1.0 + age
        self._board.distances[robot] = distances_from(self.roadmap_of(robot), np.array([cell], np.int32))[0]
        self._nearest[robot] = self._board.distances[robot, self._step.at[robot]]
        self._patience[robot] = STALLED if len(self._roadmap.room) else PATIENCE + 2 * int(self._nearest[robot])

    def set_size(self, robot: int, size: int) -> None:
        """Let another row of ``roadmap.barred`` hold for a robot, with the same goal; it must still be reached."""
        if self._sizes is not None:
            self._sizes[robot] = size

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
            decide(self._board, step, self._order())
            step.at[:] = step.to
        if len(self._roadmap.room):
            self._note_progress()
        return self.cells

    def _note_progress(self) -> None:
        apart = self._board.distances[np.arange(len(self._ages)), self._step.at]
        nearer = apart < self._nearest
        self._nearest[nearer] = apart[nearer]
        self._patience[nearer] = self._ages[nearer].astype(np.int64) + STALLED

    def _order(self) -> NDArray[np.int64]:
        """Return the robots by priority: the oldest first, but before it those in an area to which others seek to go.

        Who waits for room could otherwise stand in the way of those who would make it.
        """
        lifted = np.zeros(len(self._ages), np.bool_)
        for area in self.sought_areas:
            lifted |= self._inside(area)
        return np.lexsort((-self._ages, ~lifted))

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
