"""Kernel: hybrid A* (Dolgov, Thrun, Montemerlo and Diebel, 2008) over x, y and heading.

A node is a pose, kept exactly as it was driven to; of all poses in one cell and one bin of headings only the cheapest
is. From each node that is taken from the queue the robot drives a few short pieces, and now and then tries to drive
the curve that leads exactly to the goal. The search is over when nothing that is left in the queue can be cheaper than
the best such curve. Units are cells and radians, as in `ppaas.planners.lattice.kernels.driving`.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.lattice.kernels.driving import Ground, drive, level_ground
from ppaas.planners.lattice.kernels.pose_tree import (
    BIN,
    CLOSED,
    LEAVING,
    MOTION,
    Tree,
    find,
)  # fmt: skip
from ppaas.planners.lattice.kernels.reeds_shepp import MOST_PIECES
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve, drive_curve, weight

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Int = int | np.signedinteger[Any]

EXHAUSTED = 0
"""No node is left to work off."""
FOUND = 1
"""Nothing that is left can be cheaper than the curve to the goal."""
PAUSED = 2
"""The slice is used up: call again."""
POOL_EMPTY = 3
"""There is no room for more nodes: enlarge the tree and call again."""

STATE_SIZE = 5
NODES, SIZE, COUNT, WAIT, LAST = range(STATE_SIZE)
"""Of the search's state: nodes, entries in the heap, nodes worked off, nodes until the next curve to the goal is
tried, and the node from which the best one begins."""

CURVATURE, LENGTH, TURNED = range(3)
"""Of a motion: its curvature [1/cell] and length [cells], and the bins that it turns by."""

GREED = 1.2
"""How much estimates count: more than once, so that where the last metres are hard the search tries all that leads
there before it tries other ways. In a depot paths then cost 3 % more, and 0.5 % once their bends are taken out."""

FREE_FIELD = 1.0 / 50.0
"""Cells that a value of the cost field is worth: a free cell weighs 50."""


@njit(cache=True, nogil=True, error_model="numpy")
def estimate(
    ground: Ground, car: Car, field: Floats, outside: float, goal: Floats, x: float, y: float, theta: float
) -> float:
    """Return what is left to the goal: around obstacles for a robot that turns on the spot, or without obstacles.

    Both are asked everywhere: were the curve without obstacles only asked near the goal, all poses just outside would
    seem better than those inside, and be worked off first.
    """
    around = float(field[math.floor(y), math.floor(x)])
    if around == math.inf:
        around = outside
    word = curve(car, x, y, theta, goal[0], goal[1], goal[2])
    return max(around * FREE_FIELD, word.cost * car.radius * float(ground.rates[0]))


@njit(cache=True, nogil=True, error_model="numpy")
def _try_goal(ground: Ground, car: Car, goal: Floats, motions: Floats, tree: Tree, node: Int, best: float) -> float:
    """Return what it costs to reach the goal by the curve from a node; infinite if not less than ``best``."""
    x, y, theta = tree.spots[node]
    word = curve(car, x, y, theta, goal[0], goal[1], goal[2])
    legs = np.empty((MOST_PIECES, LEG))
    motion = tree.links[node, MOTION]
    before = motions[motion, CURVATURE] if motion >= 0 else 0.0
    left = best - tree.worths[node]
    if word.cost * car.radius * ground.rates[0] >= left:
        return math.inf
    cost, count = drive_curve(ground, car, x, y, theta, before, word, left, legs)
    length = 0.0
    for leg in range(count):
        length += abs(legs[leg, 4])
    if length > car.longest:
        return math.inf
    return float(tree.worths[node]) + cost


@njit(cache=True, nogil=True, error_model="numpy")
def _reach(
    ground: Ground, car: Car, field: Floats, outside: float, goal: Floats, motions: Floats, tree: Tree, state: Ints,
    node: Int, motion: Int,
) -> None:  # fmt: skip
    """Drive one motion from a node, and keep where it leads if it is new or cheaper than before."""
    spots, worths, links = tree.spots, tree.worths, tree.links
    curvature, length = motions[motion, CURVATURE], motions[motion, LENGTH]
    x, y, theta = spots[node]
    reached = drive(ground, x, y, theta, curvature, length, links[node, LEAVING] != 0, np.empty((0, 3)))
    if reached.cost == math.inf:
        return
    before = motions[links[node, MOTION], CURVATURE] if links[node, MOTION] >= 0 else curvature
    so_far = worths[node] + reached.cost * weight(car, curvature, length, before)
    turned = (links[node, BIN] + int(motions[motion, TURNED]) + car.bins) % car.bins
    cell = math.floor(reached.y) * ground.costs.shape[1] + math.floor(reached.x)
    place = find(tree.keys, tree.table, cell * car.bins + turned)
    other = tree.table[place]
    if other >= 0 and (links[other, CLOSED] or worths[other] <= so_far):
        return
    if other < 0:
        other = state[NODES]
        state[NODES] += 1
        tree.keys[other] = cell * car.bins + turned
        tree.table[place] = other
    spots[other] = (reached.x, reached.y, reached.theta)
    left = estimate(ground, car, field, outside, goal, reached.x, reached.y, reached.theta)
    worths[other] = so_far
    links[other] = (node, motion, turned, 0, 1 if reached.leaving else 0)
    state[SIZE] = put(tree.heap, tree.entries, tree.places, state[SIZE], other, so_far + GREED * left, left)


@njit(cache=True, nogil=True, error_model="numpy")
def expand(
    ground: Ground, car: Car, field: Floats, outside: float, goal: Floats, motions: Floats, tree: Tree, state: Ints,
    best: Floats, budget: int,
) -> int:  # fmt: skip
    """Work off up to ``budget`` nodes and tell why it stopped.

    Parameters
    ----------
    ground : Ground
    car : Car
    field : (height, width) array
        Cost-to-go of each cell for a robot that turns on the spot; infinite where blocked.
    outside : float
        What counts where it is infinite, for a robot that begins in a blocked cell.
    goal : (3,) array
        x, y, theta.
    motions : (n, 3) array
        CURVATURE, LENGTH, TURNED of each.
    tree : Tree
    state : (STATE_SIZE,) int64 array
    best : (1,) array
        What the best way to the goal costs; infinite at first.
    budget : int
        Nodes to work off before it pauses.

    Returns
    -------
    int
        EXHAUSTED, FOUND, PAUSED or POOL_EMPTY.
    """
    links = tree.links
    end = state[COUNT] + budget
    while state[SIZE] > 0:
        if best[0] <= tree.heap[1, 0]:
            return FOUND
        if state[COUNT] >= end:
            return PAUSED
        if state[NODES] + len(motions) > len(tree.keys):
            return POOL_EMPTY
        node = np.int64(tree.entries[1])
        state[SIZE] = drop(tree.heap, tree.entries, tree.places, state[SIZE], node)
        links[node, CLOSED] = 1
        state[COUNT] += 1
        state[WAIT] -= 1
        far = math.hypot(goal[0] - tree.spots[node, 0], goal[1] - tree.spots[node, 1])
        if state[WAIT] <= 0 and far <= car.longest and not links[node, LEAVING]:
            state[WAIT] = int(far / car.ratio)
            cost = _try_goal(ground, car, goal, motions, tree, node, best[0])
            if cost < best[0]:
                best[0], state[LAST] = cost, node
        for motion in range(len(motions)):
            _reach(ground, car, field, outside, goal, motions, tree, state, node, motion)
    return EXHAUSTED if best[0] == math.inf else FOUND


def warm() -> None:
    """Compile and call each kernel once, for robots of both kinds."""
    ground = level_ground(np.zeros((40, 40), np.uint8))
    motions, field = np.array([[0.0, 2.0, 0.0]]), np.zeros((40, 40))
    for backing in (False, True):
        car = Car(1.0, backing, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
        tree = Tree(
            np.full((4, 3), 5.0), np.zeros(4), np.zeros((4, 5), np.int32), np.zeros(4, np.int64),
            np.full(8, -1, np.int32), np.zeros((6, 2)), np.zeros(6, np.int32), np.zeros(4, np.int32),
        )  # fmt: skip
        tree.links[0, MOTION] = -1
        state = np.array([1, put(tree.heap, tree.entries, tree.places, 0, 0, 0.0, 0.0), 0, 0, -1])
        expand(ground, car, field, 0.0, np.array([9.0, 5.0, 0.0]), motions, tree, state, np.array([np.inf]), 9)
