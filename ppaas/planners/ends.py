"""Where a plan begins and ends: from the poses asked for to cells that a planner can join."""

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, StartOccupied, StartOutsideMap
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.weights import passable

Cell = tuple[int, int]

ESCAPE_DISTANCE = 2.0
"""How far a robot that stands too close to an obstacle may be led before it is free [m]."""

_MOVES = ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


@dataclass(frozen=True, slots=True)
class Ends:
    """The two cells to join, and what belongs to them.

    Parameters
    ----------
    start, goal : (row, column)
        Free cells.
    escape : (n, 2) int32 array
        Cells from the one the robot stands in up to, but without, ``start``; empty if it stands free.
    goal_pose : Pose2D
        The goal as asked for, or the centre of the free cell that stands for it, with the heading asked for.
    """

    start: Cell
    goal: Cell
    escape: NDArray[np.int32]
    goal_pose: Pose2D


def place_ends(costmap: Costmap, request: PlanRequest, *, allow_unknown: bool, check: Callable[[], None]) -> Ends:
    """Find the cells in which a plan begins and ends.

    A robot may stand in a cell where no plan leads: it was pushed into the inscribed radius of an obstacle (253), or
    stands in an unknown cell that plans must keep out of. navfn frees the robot's own cell, which is not enough to
    leave a band that is many cells wide. So here the way out is the shortest one to a free cell, through any cells
    that are not lethal, at most `ESCAPE_DISTANCE` long. Only a lethal cell (254) is a start in collision.

    Parameters
    ----------
    costmap : Costmap
    request : PlanRequest
        With finite poses and a tolerance of zero or more.
    allow_unknown : bool
        Whether plans may lead through unknown cells.
    check : callable
        Called often; what it raises ends the search.

    Raises
    ------
    StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
    """
    open_costs = passable(allow_unknown)
    start = _cell_of_start(costmap, request.start)
    goal = costmap.info.cell_of(request.goal.x, request.goal.y)
    if goal is None:
        raise GoalOutsideMap(f"the goal {_spot(request.goal)} lies outside the map; {_extent(costmap)}")
    way = escape(costmap, start, open_costs, check)
    if not len(way):
        raise StartOccupied(
            f"the robot at {_spot(request.start)} is not free and no free cell is within {ESCAPE_DISTANCE} m; "
            "clear the costmap or drive it out by hand"
        )
    goal_pose = request.goal
    if not open_costs[costmap.data[goal]]:
        goal = _free_cell_near(costmap, request, open_costs)
        x, y = costmap.info.to_world(goal).tolist()
        goal_pose = Pose2D(x, y, request.goal.theta)
    row, column = way[-1].tolist()
    return Ends((row, column), goal, way[:-1], goal_pose)


def escape(
    costmap: Costmap, start: Cell, open_costs: NDArray[np.bool_], check: Callable[[], None]
) -> NDArray[np.int32]:
    """Return the (n, 2) cells of the shortest way from ``start`` to a free cell, both included.

    One cell if it is free itself, none if no free cell is near. No move leads into a lethal cell or past its corner.
    """
    reach = ESCAPE_DISTANCE / costmap.info.resolution
    came: dict[Cell, Cell] = {start: start}
    best = {start: 0.0}
    queue = [(0.0, start)]
    while queue:
        distance, cell = heapq.heappop(queue)
        if open_costs[costmap.data[cell]]:
            return _way_back(came, cell)
        if distance > best[cell]:
            continue
        check()
        for neighbour, step in _moves_from(costmap, cell):
            further = distance + step
            if further <= reach and further < best.get(neighbour, math.inf):
                best[neighbour] = further
                came[neighbour] = cell
                heapq.heappush(queue, (further, neighbour))
    return np.empty((0, 2), np.int32)


def _moves_from(costmap: Costmap, cell: Cell) -> list[tuple[Cell, float]]:
    row, column = cell
    moves = []
    for down, right in _MOVES:
        if (
            down
            and right
            and not (_enterable(costmap, row, column + right) and _enterable(costmap, row + down, column))
        ):
            continue
        if _enterable(costmap, row + down, column + right):
            moves.append(((row + down, column + right), math.hypot(down, right)))
    return moves


def _enterable(costmap: Costmap, row: int, column: int) -> bool:
    inside = 0 <= row < costmap.info.height and 0 <= column < costmap.info.width
    return inside and int(costmap.data[row, column]) != LETHAL_OBSTACLE


def _way_back(came: dict[Cell, Cell], cell: Cell) -> NDArray[np.int32]:
    way = [cell]
    while came[cell] != cell:
        cell = came[cell]
        way.append(cell)
    return np.array(way[::-1], dtype=np.int32)


def _cell_of_start(costmap: Costmap, start: Pose2D) -> Cell:
    cell = costmap.info.cell_of(start.x, start.y)
    if cell is None:
        raise StartOutsideMap(f"the start {_spot(start)} lies outside the map; {_extent(costmap)}")
    if int(costmap.data[cell]) == LETHAL_OBSTACLE:
        raise StartOccupied(
            f"the robot at {_spot(start)} stands in an obstacle (cell row {cell[0]}, column {cell[1]}); "
            "correct its pose or clear the costmap"
        )
    return cell


def _free_cell_near(costmap: Costmap, request: PlanRequest, open_costs: NDArray[np.bool_]) -> Cell:
    """Return the free cell whose centre is nearest to the goal, no further than the tolerance."""
    info = costmap.info
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
        raise GoalOccupied(
            f"the goal {_spot(request.goal)} is not free, nor is any cell within the tolerance of "
            f"{request.tolerance} m; choose another goal or a larger tolerance"
        )
    return int(cells[nearest, 0]), int(cells[nearest, 1])


def _spot(pose: Pose2D) -> str:
    return f"x={pose.x:.3f} y={pose.y:.3f}"


def _extent(costmap: Costmap) -> str:
    info = costmap.info
    return (
        f"it spans {info.width * info.resolution:g}×{info.height * info.resolution:g} m from "
        f"{_spot(info.origin)}, turned by {info.origin.theta:g} rad: give a pose inside, in the frame of the map"
    )
