"""A kept plan led to the ends that are asked for, checked cell by cell, and how far it may be from the cheapest."""

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
"""How much dearer than the cheapest plan one may be that is put together, as a part of it."""


@dataclass(frozen=True, slots=True)
class LiveAndBareCostmaps:
    """Where a plan is to be driven.

    Parameters
    ----------
    live : Costmap
        With all that the robot sees and has seen.
    bare : Costmap
        Of the map alone; no cell of it costs more than in ``live``.
    allow_unknown : bool
        Whether paths may lead through unknown cells.
    """

    live: Costmap
    bare: Costmap
    allow_unknown: bool


@dataclass(frozen=True, slots=True)
class Proof:
    """That no path costs less than ``at_least``.

    Parameters
    ----------
    at_least : float
        In the weights of moves.
    by : {"distance", "stretch"}
        Because of the distance alone, or because a stretch of a cheapest path is a cheapest path itself, so that from
        near its ends to near its ends none is cheaper than it by more than the ways between them cost.
    """

    at_least: float
    by: Literal["distance", "stretch"]


@dataclass(frozen=True, slots=True)
class Offer:
    """A plan that can be driven now.

    Parameters
    ----------
    source : str
        Id of the kept plan it was made of.
    origin : Origin
        Reused or stitched.
    poses : (n, 7) float64 array
        From the start to the goal as they were asked for.
    cells : (m, 2) int32 array
        That they cross, each a neighbour of the one before.
    cost, length : float
        In the weights of moves on the live costmap, and in metres.
    proof : Proof
        What the cheapest path costs at least.
    as_kept : bool
        Whether it is the whole plan as it was kept.
    """

    source: str
    origin: Origin
    poses: Poses
    cells: NDArray[np.int32]
    cost: float
    length: float
    proof: Proof
    as_kept: bool

    @property
    def over_cheapest(self) -> float:
        """By how much of the cheapest cost it is dearer at most."""
        if self.proof.at_least > 0.0:
            return max(self.cost / self.proof.at_least - 1.0, 0.0)
        return float("inf") if self.cost > 0.0 else 0.0


def offer(
    stored: StoredPlan, question: PlanQuery, ground: LiveAndBareCostmaps, traits: Traits, bound: float = BOUND
) -> tuple[Offer | None, ReuseVerdict]:
    """Lead a kept plan to the ends that are asked for, if it can be driven now and is not too dear.

    One that is stitched must be proved to be within the bound. One that is reused must be, too, or else have been made
    by the planner asked on the bare map, and what has come up since must make it no dearer than the bound allows.

    Parameters
    ----------
    stored : StoredPlan
        Of the right map version and planner.
    question : PlanQuery
        What is asked for.
    ground : LiveAndBareCostmaps
        Where it is to be driven.
    traits : Traits
        Of the planner asked.
    bound : float
        By how much of the cheapest cost it may be dearer.

    Returns
    -------
    (Offer or None, ReuseVerdict)
        None where it is refused; the verdict says why.
    """
    joined = _joined(stored, question)
    if joined is None:
        return None, ReuseVerdict(False, "ends", {"tolerance": question.tolerance})
    poses, kept = joined
    crossed = crossed_by(ground.live.info, poses[:, :2])
    blocked = first_blocked(ground.live, crossed, passable(ground.allow_unknown))
    if blocked is not None:
        return None, ReuseVerdict(False, "costmap", {"row": blocked[0], "column": blocked[1]})
    proves = _was_cheapest(stored, question, traits)
    cells, origin = crossed.cells.astype(np.int32), _origin(stored, question)
    cost, length = path_cost(ground.live, cells), path_length(poses)
    bare_cost = cost if ground.live is ground.bare else path_cost(ground.bare, cells)
    proof = _proof(ground.bare, poses[:, :2], cells, kept if proves else None, bare_cost)
    made = Offer(stored.id, origin, poses, cells, cost, length, proof, stored.whole and poses is stored.poses)
    return _judged(made, bare_cost, bound, as_made=_is_as_made(stored, question, traits))


def _judged(made: Offer, bare_cost: float, bound: float, *, as_made: bool) -> tuple[Offer | None, ReuseVerdict]:
    over_bare = made.cost / bare_cost - 1.0 if bare_cost else 0.0
    numbers = {"over_cheapest": made.over_cheapest, "over_bare": over_bare, "bound": bound}
    if made.over_cheapest <= bound:
        return made, ReuseVerdict(True, "bound", numbers)
    if made.origin == "reused" and as_made and over_bare <= bound:
        return made, ReuseVerdict(True, "algorithm", numbers)
    return None, ReuseVerdict(False, "bound", numbers)


def _is_as_made(stored: StoredPlan, question: PlanQuery, traits: Traits) -> bool:
    """Tell whether a plan is what the planner asked makes of the bare map, and nobody could prove more of it.

    A planner of cheapest paths does not get off like that: its plans can be proved, or have become detours.
    """
    provable = traits.optimal is Optimal.ALWAYS and not stored.conditions.get("smooth", False)
    return stored.conditions.get(BARE_MAP) is True and same_planner(stored, question) and not provable


def _origin(stored: StoredPlan, question: PlanQuery) -> Origin:
    near_start = Pose2D(*stored.start).distance_to(question.start) <= question.tolerance + SAME_END
    near_goal = Pose2D(*stored.goal).distance_to(question.goal) <= question.tolerance + SAME_END
    return "reused" if stored.whole and near_start and near_goal else "stitched"


# -- joining -----------------------------------------------------------------------------------------------------------


def _joined(stored: StoredPlan, question: PlanQuery) -> tuple[Poses, slice] | None:
    """Return the poses from start to goal, and which of them are the kept ones; None if the ends cannot be joined."""
    poses, start, goal = stored.poses, question.start, question.goal
    if not len(poses):
        return None
    exact_start, exact_goal = _is_at(poses[0], start), _is_at(poses[-1], goal)
    if exact_start and exact_goal:
        return _turned(poses, start, goal, kinematic=question.kinematic)
    if question.kinematic:
        return None  # a robot that cannot turn on the spot can drive no straight line to it
    first = 0 if exact_start else _attach(poses[:, :2], start, question.tolerance)
    last = len(poses) - 1 if exact_goal else len(poses) - 1 - _attach(poses[::-1, :2], goal, question.tolerance)
    if first > last:
        return None
    kept = poses[first : last + 1, :2]
    head = [] if exact_start else [[start.x, start.y]]
    tail = [] if exact_goal else [[goal.x, goal.y]]
    points = np.concatenate([part for part in (np.array(head), kept, np.array(tail)) if len(part)])
    led = poses_along(points, goal.theta)
    led[0, 3:] = quaternion_of(start.theta)
    return led, slice(len(head), len(head) + len(kept))


def _is_at(pose: NDArray[np.float64], end: Pose2D) -> bool:
    return float(np.hypot(pose[0] - end.x, pose[1] - end.y)) <= SAME_END


def _turned(poses: Poses, start: Pose2D, goal: Pose2D, *, kinematic: bool) -> tuple[Poses, slice] | None:
    """Return poses between the right places with the headings asked for at their ends."""
    led = poses.copy()
    if len(led) > 1:
        led[0, 3:] = quaternion_of(start.theta)
    led[-1, 3:] = quaternion_of(goal.theta)
    ends, kept = led[[0, -1], 3:], poses[[0, -1], 3:]
    # A quaternion and its negative are the same heading.
    off = np.minimum(np.abs(ends - kept).max(axis=1), np.abs(ends + kept).max(axis=1))
    if np.all(off <= SAME_END):
        return poses, slice(0, len(poses))
    return None if kinematic else (led, slice(0, len(led)))


def _attach(points: NDArray[np.float64], end: Pose2D, tolerance: float) -> int:
    """Return which waypoint an end is joined to: the one after that which is nearest, so that the way goes on."""
    away = np.hypot(points[:, 0] - points[0, 0], points[:, 1] - points[0, 1]) > 2.0 * tolerance
    near = points[: int(np.argmax(away)) or len(points)]
    nearest = int(np.argmin(np.hypot(near[:, 0] - end.x, near[:, 1] - end.y)))
    return min(nearest + 1, len(points) - 1)


# -- the bound ---------------------------------------------------------------------------------------------------------


def _proof(
    bare: Costmap, points: NDArray[np.float64], cells: NDArray[np.int32], kept: slice | None, whole: float
) -> Proof:
    """Return the better of what can be proved.

    ``kept`` are the points of a stretch that is a cheapest path itself, ``whole`` is what all cells cost on the bare
    map.
    """
    rows, columns = np.abs(cells[-1] - cells[0]).tolist()
    distance = NEUTRAL * (max(rows, columns) + (SQRT2 - 1.0) * min(rows, columns))
    if kept is None:
        return Proof(distance, "distance")
    if kept == slice(0, len(points)) and len(cells) == len(points):
        stretch, back = whole, 0.0
    elif np.abs(np.diff(bare.info.to_cells(points[kept]), axis=0)).max(initial=0) > 1:
        return Proof(distance, "distance")
    else:
        stretch = _cost(bare, points[kept])
        # Whoever went from the stretch back to the start, and from the goal back to it, would have gone no cheaper.
        back = _cost(bare, points[: kept.start + 1][::-1]) + _cost(bare, points[kept.stop - 1 :][::-1])
    cheapest = stretch * (1.0 - 2.0 * RELATIVE_ERROR) - back
    return Proof(cheapest, "stretch") if cheapest > distance else Proof(distance, "distance")


def _cost(costmap: Costmap, points: NDArray[np.float64]) -> float:
    return path_cost(costmap, crossed_by(costmap.info, points).cells.astype(np.int32))


def _was_cheapest(stored: StoredPlan, question: PlanQuery, traits: Traits) -> bool:
    """Tell whether the kept plan was a cheapest one on the bare map as this robot has it."""
    on_same_costs = stored.conditions.get(BARE_MAP) is True and same_robot(stored, question)
    own_cells = traits.optimal is Optimal.ALWAYS and not stored.conditions.get("smooth", False)
    return on_same_costs and own_cells and same_planner(stored, question)
