"""Ends of a plan: from the requested poses to the free cells that a planner connects."""

import heapq
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, StartOccupied, StartOutsideMap
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.weights import passable

Cell = tuple[int, int]

ESCAPE_DISTANCE = 2.0
"""Maximum length of the escape path of a robot that is too close to an obstacle [m]."""

_START_ADVICE = {
    "zone": "choose a start outside of it, or change the zones of the map",
    "mask": "choose a start outside of it, or change the mask",
    "robot": "correct the poses of both robots, or drive one of them away",
    "person": "wait until the person has left",
    "sensor": "correct its pose or clear the costmap",
}
_GOAL_ADVICE = {
    "zone": "choose a goal outside of it, or change the zones of the map",
    "mask": "choose a goal outside of it, or change the mask",
    "robot": "wait until it has left, or choose another goal or a larger tolerance",
    "person": "wait until the person has left, or choose another goal or a larger tolerance",
}
_ANOTHER_GOAL = "choose another goal or a larger tolerance"
"""What to do by the kind of the cause; the usual advice for others."""

_MOVES = ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


@dataclass(frozen=True, slots=True)
class Ends:
    """The start and goal cells of a plan.

    Parameters
    ----------
    start, goal : (row, column)
        Free cells.
    escape : (n, 2) int32 array
        Cells from the robot's cell to ``start``, without ``start``; empty if the robot's cell is free.
    goal_pose : Pose2D
        The requested goal, or the centre of the free cell that replaces it, with the requested heading.
    """

    start: Cell
    goal: Cell
    escape: NDArray[np.int32]
    goal_pose: Pose2D


def place_ends(costmap: Costmap, request: PlanRequest, *, allow_unknown: bool, check: Callable[[], None]) -> Ends:
    """Return the cells in which a plan begins and ends.

    The robot's cell may be one that plans must not enter: within the inscribed radius of an obstacle (253), or unknown.
    navfn frees the robot's own cell, which is not enough to leave an inflated band that is many cells wide. Here the
    robot leaves by the shortest path to a free cell, through any non-lethal cells, at most `ESCAPE_DISTANCE` long.
    Only a lethal cell (254) counts as a start in collision.

    Parameters
    ----------
    costmap : Costmap
    request : PlanRequest
        With finite poses and a tolerance of zero or more.
    allow_unknown : bool
        Whether plans may lead through unknown cells.
    check : callable
        Called often; an exception from it ends the search.

    Raises
    ------
    StartOutsideMap, GoalOutsideMap
        The map does not cover the pose.
    StartOccupied
        The robot's cell is lethal, or no free cell is within `ESCAPE_DISTANCE`.
    GoalOccupied
        The goal is blocked, and so is every cell within the tolerance.
    """
    open_costs = passable(allow_unknown)
    start = _cell_of_start(costmap, request.start)
    goal = costmap.info.cell_of(request.goal.x, request.goal.y)
    if goal is None:
        raise GoalOutsideMap(f"the goal {_format_xy(request.goal)} is outside the map; {_extent(costmap)}")
    escaping = escape(costmap, start, open_costs, check)
    if not len(escaping):
        what = cause_text(costmap, request.start, "an obstacle")
        raise StartOccupied(
            f"the start {_format_xy(request.start)} is too close to {what}, and no free cell is within "
            f"{ESCAPE_DISTANCE} m; clear the costmap or drive the robot out by hand"
        )
    goal_pose = request.goal
    if not open_costs[costmap.data[goal]]:
        goal = free_cell_near(costmap, request, open_costs)
        x, y = costmap.info.to_world(goal).tolist()
        goal_pose = Pose2D(x, y, request.goal.theta)
    row, column = escaping[-1].tolist()
    return Ends((row, column), goal, escaping[:-1], goal_pose)


def escape(
    costmap: Costmap, start: Cell, open_costs: NDArray[np.bool_], check: Callable[[], None]
) -> NDArray[np.int32]:
    """Return the (n, 2) cells of the shortest path from ``start`` to a free cell, both included.

    The result is one cell if ``start`` is free, and empty if no free cell is within `ESCAPE_DISTANCE`. No move enters a
    lethal cell or cuts its corner. The search is Dijkstra's algorithm.
    """
    reach = ESCAPE_DISTANCE / costmap.info.resolution
    parents: dict[Cell, Cell] = {start: start}
    best = {start: 0.0}
    queue = [(0.0, start)]
    while queue:
        distance, cell = heapq.heappop(queue)
        if open_costs[costmap.data[cell]]:
            return _path_to(parents, cell)
        # A shorter way was found after this entry was queued.
        if distance > best[cell]:
            continue
        check()
        for neighbour, step in _moves_from(costmap, cell):
            further = distance + step
            if further <= reach and further < best.get(neighbour, math.inf):
                best[neighbour] = further
                parents[neighbour] = cell
                heapq.heappush(queue, (further, neighbour))
    return np.empty((0, 2), np.int32)


def _moves_from(costmap: Costmap, cell: Cell) -> list[tuple[Cell, float]]:
    row, column = cell
    moves = []
    for down, right in _MOVES:
        if (
            down
            and right
            and not (_is_enterable(costmap, row, column + right) and _is_enterable(costmap, row + down, column))
        ):
            continue
        if _is_enterable(costmap, row + down, column + right):
            moves.append(((row + down, column + right), math.hypot(down, right)))
    return moves


def _is_enterable(costmap: Costmap, row: int, column: int) -> bool:
    inside = 0 <= row < costmap.info.height and 0 <= column < costmap.info.width
    return inside and int(costmap.data[row, column]) != LETHAL_OBSTACLE


def _path_to(parents: dict[Cell, Cell], cell: Cell) -> NDArray[np.int32]:
    path = [cell]
    while parents[cell] != cell:
        cell = parents[cell]
        path.append(cell)
    return np.array(path[::-1], dtype=np.int32)


def _cell_of_start(costmap: Costmap, start: Pose2D) -> Cell:
    cell = costmap.info.cell_of(start.x, start.y)
    if cell is None:
        raise StartOutsideMap(f"the start {_format_xy(start)} is outside the map; {_extent(costmap)}")
    if int(costmap.data[cell]) == LETHAL_OBSTACLE:
        raise StartOccupied(
            f"the start {_format_xy(start)} is in {cause_text(costmap, start, 'an obstacle')} (cell row {cell[0]}, "
            f"column {cell[1]}); {_advice(costmap, start, _START_ADVICE)}"
        )
    return cell


def free_cell_near(costmap: Costmap, request: PlanRequest, open_costs: NDArray[np.bool_]) -> Cell:
    """Return the free cell whose centre is nearest to the goal, within the tolerance."""
    info = costmap.info
    # A tolerance may be far larger than the map.
    reach = min(request.tolerance, (info.width + info.height) * info.resolution)
    row, column = (int(v) for v in info.to_cells((request.goal.x, request.goal.y)))
    margin = math.ceil(reach / info.resolution) + 1
    top, left = max(0, row - margin), max(0, column - margin)
    window = costmap.data[top : row + margin + 1, left : column + margin + 1]
    cells = np.argwhere(open_costs[window]) + np.array((top, left))
    offsets = info.to_world(cells) - (request.goal.x, request.goal.y)
    distances = np.hypot(offsets[:, 0], offsets[:, 1])
    nearest = int(np.argmin(distances)) if len(cells) else -1
    if nearest < 0 or distances[nearest] > request.tolerance:
        if int(costmap.data[row, column]) == NO_INFORMATION:
            raise GoalOccupied(
                f"the goal {_format_xy(request.goal)} is in unknown space, with no free cell within the tolerance of "
                f"{request.tolerance} m; choose a goal that the map shows as free, or set allow_unknown of the planner"
            )
        where = "is in" if int(costmap.data[row, column]) == LETHAL_OBSTACLE else "is too close to"
        what = cause_text(costmap, request.goal, "an obstacle")
        raise GoalOccupied(
            f"the goal {_format_xy(request.goal)} {where} {what}, and all cells within the tolerance of "
            f"{request.tolerance} m are blocked; {_advice(costmap, request.goal, _GOAL_ADVICE)}"
        )
    return int(cells[nearest, 0]), int(cells[nearest, 1])


def cause_text(costmap: Costmap, pose: Pose2D, otherwise: str) -> str:
    """Return what makes the place of a pose lethal, in words; ``otherwise`` if that is not known."""
    cause = None if costmap.causes is None else costmap.causes(pose.x, pose.y)
    return otherwise if cause is None else cause.text


def _advice(costmap: Costmap, pose: Pose2D, advices: Mapping[str, str]) -> str:
    cause = None if costmap.causes is None else costmap.causes(pose.x, pose.y)
    usual = "correct its pose or clear the costmap" if advices is _START_ADVICE else _ANOTHER_GOAL
    return advices.get(cause.kind, usual) if cause is not None else usual


def _format_xy(pose: Pose2D) -> str:
    return f"x={pose.x:.3f} y={pose.y:.3f}"


def _extent(costmap: Costmap) -> str:
    info = costmap.info
    return (
        f"the map covers {info.width * info.resolution:g}×{info.height * info.resolution:g} m from "
        f"{_format_xy(info.origin)}, rotated by {info.origin.theta:g} rad: give a pose inside, in the frame of the map"
    )
