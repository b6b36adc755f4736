"""Stitching: a stored plan joined to the requested ends, checked cell by cell, with a bound on its excess cost."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, Poses, poses_along, quaternion_of
from ppaas.planners.path import path_cost, path_length
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.weights import NEUTRAL, RELATIVE_ERROR, SQRT2, passable
from ppaas.plans.reuse.criteria import SAME_END, ReuseVerdict
from ppaas.plans.reuse.crossed_cells import crossed_by, first_blocked
from ppaas.plans.stored import BARE_MAP, Origin, PlanQuery, StoredPlan, same_planner, same_robot

BOUND = 0.05
"""Largest accepted excess cost over the cheapest plan, as a fraction of its cost."""


@dataclass(frozen=True, slots=True)
class LiveAndBareCostmaps:
    """The costmaps on which a plan is checked.

    Parameters
    ----------
    live : Costmap
        Costmap with everything that the robot sees and has seen.
    bare : Costmap
        Costmap of the map alone; no cell of it costs more than in ``live``.
    allow_unknown : bool
        Whether paths may lead through unknown cells.
    """

    live: Costmap
    bare: Costmap
    allow_unknown: bool


@dataclass(frozen=True, slots=True)
class CostBound:
    """A lower bound of the cost of any path between the requested ends.

    Parameters
    ----------
    at_least : float
        The bound, in the weights of moves.
    by : {"distance", "segment"}
        Its source: the octile distance; or the fact that a part of a cheapest path is itself a cheapest path. In the
        second case no path between positions near its ends is cheaper than the part, minus the cost of the connections
        between them.
    """

    at_least: float
    by: Literal["distance", "segment"]


@dataclass(frozen=True, slots=True)
class Offer:
    """A plan that can be driven now.

    Parameters
    ----------
    source : str
        Id of the stored plan that it was made of.
    origin : Origin
        Reused or stitched.
    poses : (n, 7) float64 array
        Poses from the requested start to the requested goal.
    cells : (m, 2) int32 array
        Row, column of the cells that they cross; consecutive cells are neighbours.
    cost, length : float
        Cost in the weights of moves on the live costmap, and length [m].
    lower_bound : CostBound
        Lower bound of the cost of the cheapest path.
    as_kept : bool
        Whether it is the whole stored plan, unchanged.
    """

    source: str
    origin: Origin
    poses: Poses
    cells: NDArray[np.int32]
    cost: float
    length: float
    lower_bound: CostBound
    as_kept: bool

    @property
    def over_cheapest(self) -> float:
        """Upper bound of the excess cost over the cheapest path, as a fraction of its cost."""
        if self.lower_bound.at_least > 0.0:
            return max(self.cost / self.lower_bound.at_least - 1.0, 0.0)
        return float("inf") if self.cost > 0.0 else 0.0


def offer(
    stored: StoredPlan, query: PlanQuery, costmaps: LiveAndBareCostmaps, traits: Traits, bound: float = BOUND
) -> tuple[Offer | None, ReuseVerdict]:
    """Join a stored plan to the requested ends, if it can be driven now and does not cost too much.

    A stitched plan must be verified to be within the bound. A reused plan must be too; or the requested planner must
    have made it on the bare map, and obstacles seen since must not raise its cost by more than the bound.

    Parameters
    ----------
    stored : StoredPlan
        A plan of the right map version and planner.
    query : PlanQuery
        The search.
    costmaps : LiveAndBareCostmaps
        The costmaps to check it on.
    traits : Traits
        Traits of the requested planner.
    bound : float
        Largest accepted excess cost, as a fraction of the cheapest cost.

    Returns
    -------
    (Offer or None, ReuseVerdict)
        None if the plan is refused; the verdict gives the reason.
    """
    joined = _joined_to_ends(stored, query)
    if joined is None:
        return None, ReuseVerdict(False, "ends", {"tolerance": query.tolerance})
    poses, kept = joined
    crossed = crossed_by(costmaps.live.info, poses[:, :2])
    blocked = first_blocked(costmaps.live, crossed, passable(costmaps.allow_unknown))
    if blocked is not None:
        return None, ReuseVerdict(False, "costmap", {"row": blocked[0], "column": blocked[1]})
    is_cheapest = _was_cheapest(stored, query, traits)
    cells, origin = crossed.cells.astype(np.int32), _origin(stored, query)
    cost, length = path_cost(costmaps.live, cells), path_length(poses)
    bare_cost = cost if costmaps.live is costmaps.bare else path_cost(costmaps.bare, cells)
    lower_bound = _lower_bound(costmaps.bare, poses[:, :2], cells, kept if is_cheapest else None, bare_cost)
    candidate = Offer(
        stored.id, origin, poses, cells, cost, length, lower_bound, stored.whole and poses is stored.poses
    )
    return _judged(candidate, bare_cost, bound, bare_map_plan=_is_bare_map_plan(stored, query, traits))


def _judged(
    candidate: Offer, bare_cost: float, bound: float, *, bare_map_plan: bool
) -> tuple[Offer | None, ReuseVerdict]:
    over_bare = candidate.cost / bare_cost - 1.0 if bare_cost else 0.0
    numbers = {"over_cheapest": candidate.over_cheapest, "over_bare": over_bare, "bound": bound}
    if candidate.over_cheapest <= bound:
        return candidate, ReuseVerdict(True, "bound", numbers)
    if candidate.origin == "reused" and bare_map_plan and over_bare <= bound:
        return candidate, ReuseVerdict(True, "algorithm", numbers)
    return None, ReuseVerdict(False, "bound", numbers)


def _is_bare_map_plan(stored: StoredPlan, query: PlanQuery, traits: Traits) -> bool:
    """Return whether the requested planner would make this plan on the bare map, and its cost cannot be verified.

    Plans of a planner of cheapest paths do not count: their cost can be verified, so a failure means they have become
    detours.
    """
    verifiable = traits.optimal is Optimal.ALWAYS and not stored.conditions.get("smooth", False)
    return stored.conditions.get(BARE_MAP) is True and same_planner(stored, query) and not verifiable


def _origin(stored: StoredPlan, query: PlanQuery) -> Origin:
    near_start = Pose2D(*stored.start).distance_to(query.start) <= query.tolerance + SAME_END
    near_goal = Pose2D(*stored.goal).distance_to(query.goal) <= query.tolerance + SAME_END
    return "reused" if stored.whole and near_start and near_goal else "stitched"


# -- joining -----------------------------------------------------------------------------------------------------------


def _joined_to_ends(stored: StoredPlan, query: PlanQuery) -> tuple[Poses, slice] | None:
    """Return poses from start to goal, and the slice of them that is stored; None if the ends cannot be joined."""
    poses, start, goal = stored.poses, query.start, query.goal
    if not len(poses):
        return None
    exact_start, exact_goal = _is_at(poses[0], start), _is_at(poses[-1], goal)
    if exact_start and exact_goal:
        return _with_end_headings(poses, start, goal, kinematic=query.kinematic)
    if query.kinematic:
        return None  # a robot that cannot turn on the spot cannot follow the straight connection
    first = 0 if exact_start else _attachment_index(poses[:, :2], start, query.tolerance)
    last = len(poses) - 1 if exact_goal else len(poses) - 1 - _attachment_index(poses[::-1, :2], goal, query.tolerance)
    if first > last:
        return None
    kept = poses[first : last + 1, :2]
    head = [] if exact_start else [[start.x, start.y]]
    tail = [] if exact_goal else [[goal.x, goal.y]]
    points = np.concatenate([part for part in (np.array(head), kept, np.array(tail)) if len(part)])
    joined_poses = poses_along(points, goal.theta)
    joined_poses[0, 3:] = quaternion_of(start.theta)
    return joined_poses, slice(len(head), len(head) + len(kept))


def _is_at(pose: NDArray[np.float64], end: Pose2D) -> bool:
    return float(np.hypot(pose[0] - end.x, pose[1] - end.y)) <= SAME_END


def _with_end_headings(poses: Poses, start: Pose2D, goal: Pose2D, *, kinematic: bool) -> tuple[Poses, slice] | None:
    """Return poses with the requested headings at both ends; None for a kinematic planner if that changes a heading."""
    # A copy, because the poses of a record are read-only.
    joined_poses = poses.copy()
    if len(joined_poses) > 1:
        joined_poses[0, 3:] = quaternion_of(start.theta)
    joined_poses[-1, 3:] = quaternion_of(goal.theta)
    ends, kept = joined_poses[[0, -1], 3:], poses[[0, -1], 3:]
    # A quaternion and its negative are the same heading.
    off = np.minimum(np.abs(ends - kept).max(axis=1), np.abs(ends + kept).max(axis=1))
    if np.all(off <= SAME_END):
        return poses, slice(0, len(poses))
    return None if kinematic else (joined_poses, slice(0, len(joined_poses)))


def _attachment_index(points: NDArray[np.float64], end: Pose2D, tolerance: float) -> int:
    """Return the index of the waypoint to join an end to: the one after the nearest, so that the path moves forward."""
    away = np.hypot(points[:, 0] - points[0, 0], points[:, 1] - points[0, 1]) > 2.0 * tolerance
    # Not beyond: the path may come back near its end much later.
    near = points[: int(np.argmax(away)) or len(points)]
    nearest = int(np.argmin(np.hypot(near[:, 0] - end.x, near[:, 1] - end.y)))
    return min(nearest + 1, len(points) - 1)


# -- lower bound of the cost -------------------------------------------------------------------------------------------


def _lower_bound(
    bare: Costmap, points: NDArray[np.float64], cells: NDArray[np.int32], kept: slice | None, whole: float
) -> CostBound:
    """Return the better lower bound of the cost.

    ``kept`` is the slice of points that is a cheapest path itself, or None. ``whole`` is the cost of all cells on the
    bare map.
    """
    rows, columns = np.abs(cells[-1] - cells[0]).tolist()
    distance = NEUTRAL * (max(rows, columns) + (SQRT2 - 1.0) * min(rows, columns))
    if kept is None:
        return CostBound(distance, "distance")
    # Every pose is in another cell: the cost of all cells is known already.
    if kept == slice(0, len(points)) and len(cells) == len(points):
        segment, back = whole, 0.0
    # Poses with cells between them: the stored cells are not known, only those of the straight lines.
    elif np.abs(np.diff(bare.info.to_cells(points[kept]), axis=0)).max(initial=0) > 1:
        return CostBound(distance, "distance")
    else:
        segment = _cost(bare, points[kept])
        # Triangle inequality: segment <= connection back to the start + cheapest path + connection back from the goal.
        back = _cost(bare, points[: kept.start + 1][::-1]) + _cost(bare, points[kept.stop - 1 :][::-1])
    cheapest = segment * (1.0 - 2.0 * RELATIVE_ERROR) - back
    return CostBound(cheapest, "segment") if cheapest > distance else CostBound(distance, "distance")


def _cost(costmap: Costmap, points: NDArray[np.float64]) -> float:
    return path_cost(costmap, crossed_by(costmap.info, points).cells.astype(np.int32))


def _was_cheapest(stored: StoredPlan, query: PlanQuery, traits: Traits) -> bool:
    """Return whether the stored plan was a cheapest path on the same bare costmap as this robot's."""
    on_same_costs = stored.conditions.get(BARE_MAP) is True and same_robot(stored, query)
    own_cells = traits.optimal is Optimal.ALWAYS and not stored.conditions.get("smooth", False)
    return on_same_costs and own_cells and same_planner(stored, query)
