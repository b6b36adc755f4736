"""The search of the kinematic planner: hybrid A* in slices, and what it found as legs."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.planners.kernels.indexed_heap import put
from ppaas.planners.lattice.kernels.driving import Ground
from ppaas.planners.lattice.kernels.hybrid_astar import (
    COUNT,
    CURVATURE,
    EXHAUSTED,
    FOUND,
    LAST,
    LENGTH,
    PAUSED,
    POOL_EMPTY,
    SIZE,
    STATE_SIZE,
    expand,
)  # fmt: skip
from ppaas.planners.lattice.kernels.hybrid_astar import NODES as NODE_COUNT
from ppaas.planners.lattice.kernels.pose_tree import MOTION, PARENT, Tree, fill_table
from ppaas.planners.lattice.kernels.reeds_shepp import MOST_PIECES
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve, drive_curve
from ppaas.planners.lattice.parameters import REEDS_SHEPP, LatticeParameters

Floats = NDArray[np.float64]

SLICE_NODES = 100
"""Nodes worked off between two checks: about 2 ms."""

FIRST_ROOM = 1 << 13
"""Nodes that the tree has room for to begin with."""


def car_of(parameters: LatticeParameters, resolution: float) -> Car:
    """Return how the robot moves, on cells of that edge [m]."""
    radius = max(1.0, parameters.minimum_turning_radius / resolution)
    return Car(
        radius=radius,
        backing=parameters.motion_model_for_search == REEDS_SHEPP,
        bins=parameters.angle_quantization_bins,
        reverse=float(parameters.reverse_penalty),
        turn=float(parameters.non_straight_penalty),
        change=float(parameters.change_penalty),
        ratio=float(parameters.analytic_expansion_ratio),
        longest=max(parameters.analytic_expansion_max_length / resolution, 5.0 * radius),
    )


def motions_of(car: Car, *, interpolated: bool) -> Floats:
    """Return the (n, 3) motions from a node: curvature [1/cell], length [cells], bins turned by.

    All are as long as the sharpest turn: it leads out of its cell, as it is longer than a diagonal, and turns by
    whole bins, so that after any of them the heading is a whole number of bins from that at the start.
    """
    bin_ = 2.0 * math.pi / car.bins
    sharpest = math.ceil(2.0 * math.asin(math.sqrt(0.5) / car.radius) / bin_ - 1e-9)
    length = sharpest * bin_ * car.radius
    turns = range(1, sharpest + 1) if interpolated else (sharpest,)
    bins = [0, *(sign * turn for turn in turns for sign in (1, -1))]
    ahead = [(turned * bin_ / length, length, turned) for turned in bins]
    back = [(curvature, -length, -turned) for curvature, _, turned in ahead] if car.backing else []
    return np.array(ahead + back)


class PoseSearch:
    """A search for the cheapest way from one pose to another.

    Parameters
    ----------
    ground : Ground
    car : Car
    field : (height, width) array
        Cost-to-go of each cell.
    motions : (n, 3) array
        As ``motions_of`` gives them.
    leaving : float
        What counts in a blocked cell, for a robot that begins in one; NaN for one that does not.
    start, goal : Pose2D
        In cells.
    """

    def __init__(
        self, ground: Ground, car: Car, field: Floats, *, motions: Floats, leaving: float, start: Pose2D, goal: Pose2D
    ) -> None:
        self._ground, self._car, self._motions = ground, car, motions
        self._field, self._outside = field, leaving
        self._goal = np.array(goal)
        self._state = np.zeros(STATE_SIZE, np.int64)
        self._best = np.array([math.inf])
        self._tree = _room(FIRST_ROOM)
        tree = self._tree
        tree.spots[0] = start
        tree.worths[0] = 0.0
        tree.links[0] = -1, -1, 0, 0, not math.isnan(leaving)  # PARENT, MOTION, BIN, CLOSED, LEAVING
        tree.keys[0] = (math.floor(start.y) * ground.costs.shape[1] + math.floor(start.x)) * car.bins
        fill_table(tree.keys, tree.table, 0, 1)
        self._state[NODE_COUNT] = 1
        self._state[SIZE] = put(tree.heap, tree.entries, tree.places, 0, 0, 0.0, 0.0)

    @property
    def expanded(self) -> int:
        """How many nodes were worked off."""
        return int(self._state[COUNT])

    @property
    def has_way(self) -> bool:
        """Whether a way to the goal is known, if perhaps not the cheapest."""
        return bool(self._best[0] < math.inf)

    def run(self, check: Callable[[], None], most: int) -> int:
        """Search until it is over, or ``most`` nodes were worked off in all.

        Returns
        -------
        int
            `FOUND`: the cheapest way is known. `EXHAUSTED`: there is none. `PAUSED`: there is more to work off.
        """
        while self.expanded < most:
            check()
            outcome = expand(
                self._ground, self._car, self._field, self._outside, self._goal, self._motions, self._tree,
                self._state, self._best, min(SLICE_NODES, most - self.expanded),
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                self._grow(check)
            elif outcome in (EXHAUSTED, FOUND):
                return int(outcome)
        return PAUSED

    def from_goal(self) -> "PoseSearch":
        """Return a search from the goal backward to the start, which tries no curve: it can only end or go on.

        Where the robot cannot come to stand as it is to stand at the goal, in a dead end that it is to face out of,
        it ends sooner than that from the start, which goes on over all the rest of the map.
        """
        ends = Pose2D(*self._goal.tolist()), Pose2D(*self._tree.spots[0].tolist())
        return PoseSearch(
            self._ground, self._car._replace(longest=-1.0), self._field,
            motions=self._motions * np.array((1.0, -1.0, -1.0)), leaving=math.nan, start=ends[0], goal=ends[1],
        )  # fmt: skip

    def legs(self) -> Floats:
        """Return the (n, LEG) legs of the best way: x, y, theta where each begins, its curvature, length and cost."""
        tree, motions = self._tree, self._motions
        node, chain = int(self._state[LAST]), []
        while node >= 0:
            chain.append(node)
            node = int(tree.links[node, PARENT]) if tree.links[node, MOTION] >= 0 else -1
        nodes = np.array(chain[::-1])
        by = tree.links[nodes[1:], MOTION]
        driven = np.column_stack(
            (tree.spots[nodes[:-1]], motions[by][:, [CURVATURE, LENGTH]], np.diff(tree.worths[nodes]))
        )
        last = np.empty((MOST_PIECES, LEG))
        x, y, theta = tree.spots[nodes[-1]].tolist()
        before = float(motions[by[-1], CURVATURE]) if len(by) else 0.0
        word = curve(self._car, x, y, theta, *self._goal.tolist())
        _, count = drive_curve(self._ground, self._car, x, y, theta, before, word, math.inf, last)
        return np.concatenate((driven, last[:count]))

    def _grow(self, check: Callable[[], None]) -> None:
        old, count = self._tree, int(self._state[NODE_COUNT])
        tree = _room(2 * len(old.keys))
        for before, after in ((old.spots, tree.spots), (old.worths, tree.worths), (old.links, tree.links),
                              (old.keys, tree.keys), (old.heap, tree.heap), (old.entries, tree.entries),
                              (old.places, tree.places)):  # fmt: skip
            check()
            after[: len(before)] = before
        for first in range(0, count, SLICE_NODES << 9):
            check()
            fill_table(tree.keys, tree.table, first, min(first + (SLICE_NODES << 9), count))
        self._tree = tree


def _room(nodes: int) -> Tree:
    return Tree(
        spots=np.empty((nodes, 3)),
        worths=np.empty(nodes),
        links=np.empty((nodes, 5), np.int32),
        keys=np.empty(nodes, np.int64),
        table=np.full(2 * nodes, -1, np.int32),
        heap=np.empty((nodes + 2, 2)),
        entries=np.empty(nodes + 2, np.int32),
        places=np.zeros(nodes, np.int32),
    )
