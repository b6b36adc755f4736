"""Kernel: hybrid A* (Dolgov, Thrun, Montemerlo and Diebel, 2008) over x, y and heading.

A node is a continuous pose, stored exactly as it was reached. Of all poses in one cell and one heading bin only the
cheapest is kept. Expanding a node drives each motion primitive from it, and occasionally tries the analytic curve (a
Reeds-Shepp or Dubins curve) to the goal. The search ends when no queued node can lead to a cheaper path than the best
such curve. Units are cells and radians, as in `ppaas.planners.lattice.kernels.driving`.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.lattice.kernels.driving import DrivingSurface, drive, flat_surface
from ppaas.planners.lattice.kernels.pose_tree import (
    BIN,
    CLOSED,
    LEAVING,
    MOTION,
    PoseTree,
    find,
)  # fmt: skip
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve, drive_curve, weight

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Int = int | np.signedinteger[Any]

EXHAUSTED = 0
"""The queue is empty and no path was found."""
FOUND = 1
"""The best path is known: no queued node can improve on it."""
PAUSED = 2
"""The budget is used up: call again."""
POOL_EMPTY = 3
"""The tree is full: enlarge it and call again."""

STATE_SIZE = 5
NODES, SIZE, COUNT, WAIT, LAST = range(STATE_SIZE)
"""Elements of the search's state: number of nodes, entries in the heap, expanded nodes, expansions until the next
attempt of the analytic curve, and the node from which the best curve begins."""

CURVATURE, LENGTH, TURNED = range(3)
"""Columns of a motion: curvature [1/cell], length [cells], heading change [bins]."""

GREED = 1.2
"""Weight of the heuristic (weighted A*). Above 1 the search concentrates on nodes near the goal where the last metres
are difficult. In a depot, paths cost 3 % more than with 1, and 0.5 % more after smoothing."""

FREE_FIELD = 1.0 / 50.0
"""Factor from values of the cost field to cells of free space: a free cell weighs 50."""


@compiled
def estimate(
    surface: DrivingSurface, car: Car, field: Floats, outside: float, goal: Floats, x: float, y: float, theta: float
) -> float:
    """Return the heuristic of a pose: the maximum of two lower bounds of the cost to the goal (Dolgov et al., 2008).

    One is the cost field, which considers obstacles but not the heading. The other is the analytic curve, which
    considers the heading but not obstacles. Both are evaluated everywhere: if the curve were only evaluated near the
    goal, poses just outside that range would have lower estimates than those inside and be expanded first.
    """
    around = float(field[math.floor(y), math.floor(x)])
    if around == math.inf:
        around = outside
    word = curve(car, x, y, theta, goal[0], goal[1], goal[2])
    return max(around * FREE_FIELD, word.cost * car.radius * float(surface.rates[0]))


@compiled
def _try_goal(
    surface: DrivingSurface, car: Car, goal: Floats, motions: Floats, tree: PoseTree, node: Int, best: float
) -> float:
    """Return the path cost over a node and its analytic curve; infinite if it collides or costs ``best`` or more."""
    x, y, theta = tree.poses[node]
    word = curve(car, x, y, theta, goal[0], goal[1], goal[2])
    legs = np.empty((MAX_PIECES, LEG))
    motion = tree.links[node, MOTION]
    before = motions[motion, CURVATURE] if motion >= 0 else 0.0
    left = best - tree.costs[node]
    if word.cost * car.radius * surface.rates[0] >= left:
        return math.inf
    cost, count = drive_curve(surface, car, x, y, theta, before, word, left, legs)
    length = 0.0
    for leg in range(count):
        length += abs(legs[leg, 4])
    if length > car.longest:
        return math.inf
    return float(tree.costs[node]) + cost


@compiled
def _reach(
    surface: DrivingSurface, car: Car, field: Floats, outside: float, goal: Floats, motions: Floats, tree: PoseTree,
    state: Ints, node: Int, motion: Int,
) -> None:  # fmt: skip
    """Drive one motion from a node; store and queue the node that it leads to if it is new or now cheaper."""
    poses, costs, links = tree.poses, tree.costs, tree.links
    curvature, length = motions[motion, CURVATURE], motions[motion, LENGTH]
    x, y, theta = poses[node]
    reached = drive(surface, x, y, theta, curvature, length, links[node, LEAVING] != 0, np.empty((0, 3)))
    if reached.cost == math.inf:
        return
    before = motions[links[node, MOTION], CURVATURE] if links[node, MOTION] >= 0 else curvature
    so_far = costs[node] + reached.cost * weight(car, curvature, length, before)
    turned = (links[node, BIN] + int(motions[motion, TURNED]) + car.bins) % car.bins
    cell = math.floor(reached.y) * surface.costs.shape[1] + math.floor(reached.x)
    place = find(tree.keys, tree.table, cell * car.bins + turned)
    other = tree.table[place]
    if other >= 0 and (links[other, CLOSED] or costs[other] <= so_far):
        return
    if other < 0:
        other = state[NODES]
        state[NODES] += 1
        tree.keys[other] = cell * car.bins + turned
        tree.table[place] = other
    poses[other] = (reached.x, reached.y, reached.theta)
    left = estimate(surface, car, field, outside, goal, reached.x, reached.y, reached.theta)
    costs[other] = so_far
    links[other] = (node, motion, turned, 0, 1 if reached.leaving else 0)
    state[SIZE] = put(tree.heap, tree.entries, tree.places, state[SIZE], other, so_far + GREED * left, left)


@compiled
def expand(
    surface: DrivingSurface, car: Car, field: Floats, outside: float, goal: Floats, motions: Floats, tree: PoseTree,
    state: Ints, best: Floats, budget: int,
) -> int:  # fmt: skip
    """Expand up to ``budget`` nodes and return why the kernel stopped.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    field : (height, width) float64 array
        Cost-to-go of each cell for a robot that can turn on the spot; infinite if blocked.
    outside : float
        Cost-to-go used where ``field`` is infinite, for a robot that starts in a blocked cell.
    goal : (3,) float64 array
        x, y, theta [cells, rad].
    motions : (n, 3) float64 array
        CURVATURE, LENGTH, TURNED of each motion primitive.
    tree : PoseTree
        Nodes and queue; modified.
    state : (STATE_SIZE,) int64 array
        In and out.
    best : (1,) float64 array
        Cost of the best path to the goal so far; infinite at first. In and out.
    budget : int
        Maximum number of nodes to expand in this call.

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
        # Pop the node with the least key and close it.
        node = np.int64(tree.entries[1])
        state[SIZE] = drop(tree.heap, tree.entries, tree.places, state[SIZE], node)
        links[node, CLOSED] = 1
        state[COUNT] += 1
        state[WAIT] -= 1
        # Analytic expansion: the nearer the goal, the more often.
        far = math.hypot(goal[0] - tree.poses[node, 0], goal[1] - tree.poses[node, 1])
        if state[WAIT] <= 0 and far <= car.longest and not links[node, LEAVING]:
            state[WAIT] = int(far / car.ratio)
            cost = _try_goal(surface, car, goal, motions, tree, node, best[0])
            if cost < best[0]:
                best[0], state[LAST] = cost, node
        # Expand by all motion primitives.
        for motion in range(len(motions)):
            _reach(surface, car, field, outside, goal, motions, tree, state, node, motion)
    return EXHAUSTED if best[0] == math.inf else FOUND


def warm() -> None:
    """Compile and call each kernel once, for both motion models."""
    surface = flat_surface(np.zeros((40, 40), np.uint8))
    motions, field = np.array([[0.0, 2.0, 0.0]]), np.zeros((40, 40))
    for backing in (False, True):
        car = Car(1.0, backing, 72, 2.0, 1.2, 0.0, 3.5, 9.0)
        tree = PoseTree(
            np.full((4, 3), 5.0), np.zeros(4), np.zeros((4, 5), np.int32), np.zeros(4, np.int64),
            np.full(8, -1, np.int32), np.zeros((6, 2)), np.zeros(6, np.int32), np.zeros(4, np.int32),
        )  # fmt: skip
        tree.links[0, MOTION] = -1
        state = np.array([1, put(tree.heap, tree.entries, tree.places, 0, 0, 0.0, 0.0), 0, 0, -1])
        expand(surface, car, field, 0.0, np.array([9.0, 5.0, 0.0]), motions, tree, state, np.array([np.inf]), 9)
