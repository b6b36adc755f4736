"""Kernel: times at which robots reach their cells when all keep the order of a plan.

A robot starts to move into a cell when it has turned, and when the robot before it has reached its next cell. So each
time depends on times of earlier steps, or on those of a robot ahead in the same step; rings of these are in no plan.
Source: Hönig et al., "Persistent and Robust Execution of MAPF Schedules in Warehouses", IEEE RA-L 4(2), 2019, whose
action dependency graph this is, visited in the order of the plan.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import NO_AREAS, NOBODY, Ints
from ppaas.kernel_cache.decorators import bare

Seconds = NDArray[np.float64]


class Order(NamedTuple):
    """Steps of a plan, and how long robots take.

    Parameters
    ----------
    steps : (t, n) int32 array
        Cell of each robot at each step.
    places : (v, 2) float64 array
        Centre of each cell, in any unit of length.
    areas : (v,) uint64 array
        Areas that each cell is in (`ppaas.fleet.kernels.board.Board`).
    room : (a,) int32 array
        Number of robots that may be in each area at a time.
    paces : (n,) float64 array
        Time that each robot takes for a unit of length [s].
    turn : float
        Time of a quarter turn [s].
    """

    steps: Ints
    places: NDArray[np.float64]
    areas: NDArray[np.uint64]
    room: Ints
    paces: Seconds
    turn: float


class Passed(NamedTuple):
    """State of cells, robots and areas after the steps before.

    Parameters
    ----------
    left : (v,) float64 array
        Time at which the last robot has left each cell; 0 at first [s].
    here, there : (v,) int32 array
        Robot in each cell before and after the step, −1 for none. Both are −1 everywhere between two steps.
    headings : (n,) float64 array
        Direction of the last move of each robot [rad], NaN for none.
    turned : (n,) float64 array
        How far each robot has turned [quarter turns].
    entered, emptied : (a,) int32 array
        Number of times that a robot has entered each area, those included that were there at first, and left it.
    exits : (a, e) float64 array
        Time of each exit from an area, in the order of the plan [s]; e is their largest number, at least 1.
    """

    left: Seconds
    here: Ints
    there: Ints
    headings: NDArray[np.float64]
    turned: NDArray[np.float64]
    entered: Ints
    emptied: Ints
    exits: Seconds


@bare
def enter(order: Order, passed: Passed, here: int, there: int) -> float:
    """Count a move as one into the areas of its end; return the time from which there is room in them [s].

    Who enters beyond the room of an area takes the place of one that has left it: of the first for the first, and so on
    in the order of the plan. That one has left in an earlier step.
    """
    ready = 0.0
    if len(order.room) > 0:
        entered = order.areas[there] & ~order.areas[here]
        for area in range(len(order.room)):
            if entered >> np.uint64(area) & np.uint64(1):
                passed.entered[area] += 1
                beyond = passed.entered[area] - order.room[area]
                if beyond > 0:
                    ready = max(ready, passed.exits[area, beyond - 1])
    return ready


@bare
def leave(order: Order, passed: Passed, here: int, there: int, time: float) -> None:
    """Note a time at which a robot has left areas that the end of its move is not in."""
    if len(order.room) > 0:
        emptied = order.areas[here] & ~order.areas[there]
        for area in range(len(order.room)):
            if emptied >> np.uint64(area) & np.uint64(1):
                passed.exits[area, passed.emptied[area]] = time
                passed.emptied[area] += 1


@bare
def move(order: Order, passed: Passed, step: int, robot: int, times: Seconds) -> None:
    """Compute the time at which a robot reaches its next cell, which it moves to in a step."""
    here, there = order.steps[step, robot], order.steps[step + 1, robot]
    along_x = order.places[there, 0] - order.places[here, 0]
    along_y = order.places[there, 1] - order.places[here, 1]
    ready, ahead = times[step, robot], math.atan2(along_y, along_x)
    if not math.isnan(passed.headings[robot]):
        turned = abs(ahead - passed.headings[robot])
        quarters = min(turned, 2.0 * math.pi - turned) / (math.pi / 2.0)
        passed.turned[robot] += quarters
        ready += order.turn * quarters
    passed.headings[robot] = ahead
    ready = max(ready, passed.left[there], enter(order, passed, here, there))
    times[step + 1, robot] = passed.left[here] = ready + order.paces[robot] * math.hypot(along_x, along_y)
    leave(order, passed, here, there, times[step + 1, robot])


@bare
def pass_all(order: Order, passed: Passed, times: Seconds) -> None:
    """Compute the time at which each robot reaches its cell of each step.

    Parameters
    ----------
    order, passed
        See there.
    times : (t, n) float64 array
        Times [s]; a robot that waits has reached its cell before. The first row is given. Out.
    """
    steps, here, there = order.steps, passed.here, passed.there
    for step in range(len(steps) - 1):
        for robot in range(steps.shape[1]):
            here[steps[step, robot]] = robot
            there[steps[step + 1, robot]] = robot
        for robot in range(steps.shape[1]):
            cell, onward = steps[step, robot], steps[step + 1, robot]
            if cell == onward:
                times[step + 1, robot] = times[step, robot]
            elif here[onward] < 0:  # the first of a chain: each other one moves into the cell that the one before left
                follower = robot
                while follower >= 0:
                    move(order, passed, step, follower, times)
                    follower = there[steps[step, follower]]
        for robot in range(steps.shape[1]):
            here[steps[step, robot]] = there[steps[step + 1, robot]] = NOBODY


def passed_of(order: Order, inside: Ints, exits: int) -> Passed:
    """Return what has passed before the first step.

    Parameters
    ----------
    order : Order
    inside : (a,) int32 array
        Number of robots in each area.
    exits : int
        Largest number of times that an area is left.
    """
    cells, robots = len(order.places), order.steps.shape[1]
    return Passed(
        np.zeros(cells),
        np.full(cells, NOBODY, np.int32),
        np.full(cells, NOBODY, np.int32),
        np.full(robots, np.nan),
        np.zeros(robots),
        inside.astype(np.int32),
        np.zeros(len(inside), np.int32),
        np.zeros((len(inside), max(exits, 1))),
    )


def warm() -> None:
    """Compile and call each kernel once."""
    steps, places = np.array([[0], [1]], np.int32), np.array([[0.0, 0.0], [0.0, 1.0]])
    order = Order(steps, places, NO_AREAS, np.empty(0, np.int32), np.ones(1), 1.0)
    passed = passed_of(order, np.zeros(0, np.int32), 0)
    pass_all(order, passed, np.zeros((2, 1)))
