"""Plan of a fleet: the cell of each robot at each step, and the times at which robots reach their cells."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.timing import Order, Passed, pass_all, passed_of
from ppaas.fleet.kernels.turns import count_all
from ppaas.fleet.roadmap import Roadmap


@dataclass(frozen=True, slots=True)
class FleetPlan:
    """Conflict-free paths of all robots, in steps of the same duration.

    Parameters
    ----------
    steps : (t, n) int32 array
        Cell of each robot at each time; the first row are the starts, the last one the goals.
    bound : int
        Sum of the lengths of shortest paths, below which no cost is.
    """

    steps: NDArray[np.int32]
    bound: int

    @property
    def arrivals(self) -> NDArray[np.int64]:
        """Time of the last arrival of each robot at its goal, (n,) int64."""
        away = self.steps != self.steps[-1]
        last = len(self.steps) - np.argmax(away[::-1], axis=0)
        return np.where(away.any(axis=0), last, 0)

    @property
    def cost(self) -> int:
        """Sum of the arrivals."""
        return int(self.arrivals.sum())

    @property
    def makespan(self) -> int:
        """Time of the last arrival of all."""
        return int(self.arrivals.max(initial=0))


# -- times of a plan ---------------------------------------------------------------------------------------------------


class PlanTiming(NamedTuple):
    """Times of a plan.

    Parameters
    ----------
    times : (t, n) float64 array
        Time at which each robot reaches its cell of each step [s].
    turned : (n,) float64 array
        How far each robot turns [quarter turns]; its first direction is free.
    """

    times: NDArray[np.float64]
    turned: NDArray[np.float64]


def timing_of(
    roadmap: Roadmap,
    plan: FleetPlan,
    paces: NDArray[np.float64],
    turn: float = 0.0,
    places: NDArray[np.float64] | None = None,
) -> PlanTiming:
    """Return the time at which each robot reaches its cell of each step, when all keep the order of the plan.

    A robot starts to move into a cell when it has turned, and when the robot that was there before has reached its next
    cell. An area is entered once so many robots have left it that there is room. Otherwise no robot waits, so one may
    be ahead of the steps of others, or behind. A robot that waits in a step has reached its cell before, and has the
    same time again.

    Parameters
    ----------
    roadmap : Roadmap
    plan : FleetPlan
        A valid plan.
    paces : (n,) float64 array
        Time that each robot takes for a unit of length, above 0 [s].
    turn : float
        Time of a quarter turn [s]. A robot's first direction is free.
    places : (v, 2) float64 array, optional
        Centres of the cells, in any unit of length. By default rows and columns of a grid are places, and the unit is a
        move.
    """
    centres = roadmap.cells.astype(np.float64) if places is None else places
    order = Order(plan.steps, centres, roadmap.areas, roadmap.room, paces, float(turn))
    times, passed = np.zeros(plan.steps.shape), _at_first(order)
    pass_all(order, passed, times)
    return PlanTiming(times, passed.turned)


def turns_of(roadmap: Roadmap, plan: FleetPlan) -> NDArray[np.int32]:
    """Return the number of quarter turns of each robot on a grid, (n,) int32; its first direction is free."""
    turns = np.zeros(plan.steps.shape[1], np.int32)
    count_all(roadmap.cells, np.ascontiguousarray(plan.steps.T), turns)
    return turns


def _at_first(order: Order) -> Passed:
    """Return what has passed before the first step, with memory for all that leave an area."""
    inside, exits = np.zeros(len(order.room), np.int32), 0
    for area in range(len(order.room)):
        within = (order.areas[order.steps] >> np.uint64(area) & np.uint64(1)).astype(np.bool_)
        inside[area] = within[0].sum()
        exits = max(exits, int((within[:-1] & ~within[1:]).sum()))
    return passed_of(order, inside, exits)
