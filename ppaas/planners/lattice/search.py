"""Search of the kinematic planner: hybrid A* in slices on a costmap prepared for the footprint; its result as legs."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.planners.ends import ESCAPE_DISTANCE
from ppaas.planners.kernels.indexed_heap import put
from ppaas.planners.lattice.kernels.driving import DrivingSurface
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
from ppaas.planners.lattice.kernels.pose_tree import MOTION, PARENT, PoseTree, fill_table
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve, drive_curve
from ppaas.planners.lattice.parameters import REEDS_SHEPP, LatticeParameters
from ppaas.planners.weights import FACTOR, NEUTRAL, passable

# -- the search --------------------------------------------------------------------------------------------------------

Floats = NDArray[np.float64]

SLICE_NODES = 100
"""Nodes expanded between two checks: about 2 ms."""

INITIAL_CAPACITY = 1 << 13
"""Initial capacity of the tree [nodes]."""


def car_of(parameters: LatticeParameters, resolution: float) -> Car:
    """Return the kinematics of the robot in units of cells, whose size is ``resolution`` [m]."""
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
    """Return the (n, 3) motion primitives: curvature [1/cell], length [cells], heading change [bins].

    All are as long as the sharpest turn. Its chord is at least a cell's diagonal, so it leaves its cell, and it turns
    by whole bins: after any motion the heading differs from that at the start by a whole number of bins.
    """
    bin_ = 2.0 * math.pi / car.bins
    sharpest = math.ceil(2.0 * math.asin(math.sqrt(0.5) / car.radius) / bin_ - 1e-9)
    length = sharpest * bin_ * car.radius
    turns = range(1, sharpest + 1) if interpolated else (sharpest,)
    bins = [0, *(sign * turn for turn in turns for sign in (1, -1))]
    ahead = [(turned * bin_ / length, length, turned) for turned in bins]
    back = [(curvature, -length, -turned) for curvature, _, turned in ahead] if car.backing else []
    return np.array(ahead + back)


class HybridAStarSearch:
    """Search for the cheapest path from one pose to another.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    field : (height, width) array
        Cost-to-go of each cell.
    motions : (n, 3) array
        Motion primitives, as returned by ``motions_of``.
    leaving : float
        Cost-to-go of blocked cells, for a robot that starts in one; NaN if the start is free.
    start, goal : Pose2D
        In cells.
    """

    def __init__(
        self,
        surface: DrivingSurface,
        car: Car,
        field: Floats,
        *,
        motions: Floats,
        leaving: float,
        start: Pose2D,
        goal: Pose2D,
    ) -> None:
        self._surface, self._car, self._motions = surface, car, motions
        self._field, self._outside = field, leaving
        self._goal = np.array(goal)
        self._state = np.zeros(STATE_SIZE, np.int64)
        self._best = np.array([math.inf])
        self._tree = _empty_tree(INITIAL_CAPACITY)
        tree = self._tree
        tree.poses[0] = start
        tree.costs[0] = 0.0
        tree.links[0] = -1, -1, 0, 0, not math.isnan(leaving)  # PARENT, MOTION, BIN, CLOSED, LEAVING
        tree.keys[0] = (math.floor(start.y) * surface.costs.shape[1] + math.floor(start.x)) * car.bins
        fill_table(tree.keys, tree.table, 0, 1)
        self._state[NODE_COUNT] = 1
        self._state[SIZE] = put(tree.heap, tree.entries, tree.places, 0, 0, 0.0, 0.0)

    @property
    def expanded(self) -> int:
        """Number of expanded nodes."""
        return int(self._state[COUNT])

    @property
    def has_path(self) -> bool:
        """Whether a path to the goal is known, although perhaps not the cheapest."""
        return bool(self._best[0] < math.inf)

    def run(self, check: Callable[[], None], most: int) -> int:
        """Search until the result is final, or ``most`` nodes have been expanded in total.

        Returns
        -------
        int
            `FOUND`: the cheapest path is known. `EXHAUSTED`: there is none. `PAUSED`: the limit is reached.
        """
        while self.expanded < most:
            check()
            outcome = expand(
                self._surface, self._car, self._field, self._outside, self._goal, self._motions, self._tree,
                self._state, self._best, min(SLICE_NODES, most - self.expanded),
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                self._grow(check)
            elif outcome in (EXHAUSTED, FOUND):
                return int(outcome)
        return PAUSED

    def from_goal(self) -> "HybridAStarSearch":
        """Return a search backward from the goal, without analytic curves: it can only be exhausted or continue.

        If the goal pose cannot be reached, such as one that faces out of a dead end, the backward search is exhausted
        soon, whereas the forward search would expand the rest of the map.
        """
        ends = Pose2D(*self._goal.tolist()), Pose2D(*self._tree.poses[0].tolist())
        return HybridAStarSearch(
            self._surface, self._car._replace(longest=-1.0), self._field,
            motions=self._motions * np.array((1.0, -1.0, -1.0)), leaving=math.nan, start=ends[0], goal=ends[1],
        )  # fmt: skip

    def legs(self) -> Floats:
        """Return the (n, LEG) legs of the best path: x, y, theta at its begin, curvature, length and cost of each."""
        tree, motions = self._tree, self._motions
        node, chain = int(self._state[LAST]), []
        while node >= 0:
            chain.append(node)
            node = int(tree.links[node, PARENT]) if tree.links[node, MOTION] >= 0 else -1
        nodes = np.array(chain[::-1])
        by = tree.links[nodes[1:], MOTION]
        driven = np.column_stack(
            (tree.poses[nodes[:-1]], motions[by][:, [CURVATURE, LENGTH]], np.diff(tree.costs[nodes]))
        )
        last = np.empty((MAX_PIECES, LEG))
        x, y, theta = tree.poses[nodes[-1]].tolist()
        before = float(motions[by[-1], CURVATURE]) if len(by) else 0.0
        word = curve(self._car, x, y, theta, *self._goal.tolist())
        _, count = drive_curve(self._surface, self._car, x, y, theta, before, word, math.inf, last)
        return np.concatenate((driven, last[:count]))

    def _grow(self, check: Callable[[], None]) -> None:
        old, count = self._tree, int(self._state[NODE_COUNT])
        tree = _empty_tree(2 * len(old.keys))
        for before, after in ((old.poses, tree.poses), (old.costs, tree.costs), (old.links, tree.links),
                              (old.keys, tree.keys), (old.heap, tree.heap), (old.entries, tree.entries),
                              (old.places, tree.places)):  # fmt: skip
            check()
            after[: len(before)] = before
        for first in range(0, count, SLICE_NODES << 9):
            check()
            fill_table(tree.keys, tree.table, first, min(first + (SLICE_NODES << 9), count))
        self._tree = tree


def _empty_tree(nodes: int) -> PoseTree:
    return PoseTree(
        poses=np.empty((nodes, 3)),
        costs=np.empty(nodes),
        links=np.empty((nodes, 5), np.int32),
        keys=np.empty(nodes, np.int64),
        table=np.full(2 * nodes, -1, np.int32),
        heap=np.empty((nodes + 2, 2)),
        entries=np.empty(nodes + 2, np.int32),
        places=np.zeros(nodes, np.int32),
    )


# -- driving surface: the costmap with its own weights, prepared for footprint checks ----------------------------------

SLICE_SETUP = 1 << 20
"""Cells prepared between two checks."""

MAX_FREE_COST = INSCRIBED_INFLATED_OBSTACLE - 1
"""Highest cost of a free cell: 252."""


def reweighted_costs(parameters: LatticeParameters) -> NDArray[np.uint8]:
    """Return for each of the 256 costs the equivalent cost under the grid planners' weight, 50 + 0.8·cost.

    With it one map serves both the search over poses and the cost field that guides the search.
    """
    per_unit = parameters.cost_penalty * NEUTRAL / (FACTOR * MAX_FREE_COST)
    costs = np.minimum(np.arange(256.0) * per_unit, MAX_FREE_COST).astype(np.uint8)
    closed = ~passable(parameters.allow_unknown)
    costs[closed] = INSCRIBED_INFLATED_OBSTACLE
    costs[LETHAL_OBSTACLE] = LETHAL_OBSTACLE
    return costs


def prepare_surface(
    costmap: Costmap, start: Pose2D, parameters: LatticeParameters, check: Callable[[], None]
) -> DrivingSurface:
    """Prepare a costmap for driving.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    start : Pose2D
        Start of the plan, in cells; x along the columns.
    parameters : LatticeParameters
    check : callable
        Called at least every few milliseconds; an exception from it ends the work.
    """
    resolution = costmap.info.resolution
    height, width = costmap.info.shape
    corners = parameters.outline() / resolution
    table = reweighted_costs(parameters)
    lethal = np.zeros(256, np.bool_)
    lethal[LETHAL_OBSTACLE], lethal[NO_INFORMATION] = True, not parameters.allow_unknown
    costs = np.empty((height, width), np.uint8)
    sums = np.zeros((height, width + 1) if len(corners) else (0, 0), np.int32)
    rows = max(1, SLICE_SETUP // width)
    for first in range(0, height, rows):
        check()
        band = slice(first, first + rows)
        np.take(table, costmap.data[band], out=costs[band])
        if len(corners):
            np.cumsum(lethal[costmap.data[band]], axis=1, out=sums[band, 1:])
    return DrivingSurface(
        costs=costs,
        rates=1.0 - parameters.retrospective_penalty + FACTOR / NEUTRAL * np.arange(256.0),
        corners=corners,
        reach=float(np.hypot(corners[:, 0], corners[:, 1]).max(initial=0.0)),
        sums=sums,
        outside=parameters.allow_unknown,
        x=start.x,
        y=start.y,
        escape=ESCAPE_DISTANCE / resolution,
    )
