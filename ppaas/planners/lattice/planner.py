"""Planner for robots that cannot turn on the spot, with smoothing of its paths."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

import numpy as np
from numba import config
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, NoValidPath, PlanTimeout, StartOccupied
from ppaas.geometry import Pose2D, Poses, wrap_angle
from ppaas.maps.grid import GridInfo
from ppaas.parameters import read_parameters
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.ends import Ends, cause_text, place_ends
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.kernels import indexed_heap
from ppaas.planners.lattice.kernels import driving, dubins, hybrid_astar, pose_tree, reeds_shepp, shortcuts, steering
from ppaas.planners.lattice.kernels.driving import DrivingSurface, fits, sample_count
from ppaas.planners.lattice.kernels.hybrid_astar import EXHAUSTED, PAUSED
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES
from ppaas.planners.lattice.kernels.shortcuts import cut, join, trace
from ppaas.planners.lattice.kernels.steering import LEG, Car
from ppaas.planners.lattice.parameters import DUBIN, LatticeParameters
from ppaas.planners.lattice.search import HybridAStarSearch, car_of, motions_of, prepare_surface
from ppaas.planners.path import path_cost, path_length
from ppaas.planners.traits import Traits
from ppaas.planners.watch import Watch

# -- shortcuts by curves that cost less --------------------------------------------------------------------------------

# -- the planner -------------------------------------------------------------------------------------------------------


Floats = NDArray[np.float64]

PASSES = 3
"""Maximum number of passes; each tries other poses of the path."""

MAX_POSES = 72
"""Maximum number of poses tried in a pass: the work grows with their square."""

SLICE_POSES = 4
"""Poses from which curves are tried between two checks: a few milliseconds."""

LAST_PASS_RATIO = 0.995
"""A pass that reduces the cost to no less than this fraction is the last."""


def smooth(surface: DrivingSurface, car: Car, legs: Floats, check: Callable[[], None]) -> Floats:
    """Return the (n, LEG) legs of a path that costs no more.

    Parameters
    ----------
    surface : DrivingSurface
    car : Car
    legs : (m, LEG) array
        Legs of the path. Those that begin in a blocked cell are not changed.
    check : callable
        Called every few milliseconds; an exception from it ends the work.
    """
    rows, columns = np.floor(legs[:, 1]).astype(np.int64), np.floor(legs[:, 0]).astype(np.int64)
    free = int(np.argmax(surface.costs[rows, columns] < INSCRIBED_INFLATED_OBSTACLE))
    unchanged, path = legs[:free], legs[free:]
    cost = float(path[:, 5].sum())
    for number in range(PASSES):
        path = _shortened(surface, car, path, number, check)
        before, cost = cost, float(path[:, 5].sum())
        if cost > before * LAST_PASS_RATIO:
            break
    return np.concatenate((unchanged, path))


def _shortened(surface: DrivingSurface, car: Car, legs: Floats, number: int, check: Callable[[], None]) -> Floats:
    check()
    total = float(np.abs(legs[:, 4]).sum())
    spacing = max(1.0, total / MAX_POSES / 2.0)
    parts = np.empty((len(legs) + int(total / spacing) + 1, LEG))
    legs = parts[: cut(surface, car, legs, spacing, parts)]
    # Pick one end of a part every two spacings; odd passes pick those in between.
    driven = np.concatenate(([0.0], np.cumsum(np.abs(legs[:, 4]))))
    wanted = np.arange(0.5 * (number % 2), total / (2.0 * spacing), 1.0) * 2.0 * spacing
    picks = np.unique(np.concatenate(([0], np.searchsorted(driven[:-1], wanted), [len(legs)])))
    along = np.concatenate(([0.0], np.cumsum(legs[:, 5])))[picks]
    poses = np.concatenate((legs[:, :3], [_end(legs)]))[picks]
    count = len(picks)
    costs, origins = along.copy(), np.arange(-1, count - 1, dtype=np.int32)
    curves, counts = np.empty((count, MAX_PIECES, LEG)), np.zeros(count, np.int32)
    for first in range(0, count - 1, SLICE_POSES):
        check()
        last = min(first + SLICE_POSES, count - 1)
        join(surface, car, poses, along, costs, origins, curves, counts, first, last)
    chosen = []
    at = count - 1
    while at > 0:
        origin = int(origins[at])
        chosen.append(curves[at, : counts[at]] if counts[at] else legs[picks[origin] : picks[at]])
        at = origin
    return np.concatenate(chosen[::-1]) if chosen else legs


def _end(legs: Floats) -> tuple[float, float, float]:
    """Return x, y, theta at the end of the last leg."""
    x, y, theta, curvature, length, _ = legs[-1].tolist()
    turn = curvature * length
    chord = length * float(np.sinc(0.5 * turn / np.pi))
    return x + chord * np.cos(theta + 0.5 * turn), y + chord * np.sin(theta + 0.5 * turn), theta + turn


MIN_LEG = 1e-9
"""Shorter legs are dropped [cells]."""

DOUBTFUL = 5_000
"""Expanded nodes after which a backward search from the goal also checks whether a path exists: the effort of a hard
plan."""


class Lattice(Planner):
    """Hybrid A* over poses, with arcs and straight pieces, like Nav2's SmacPlannerHybrid.

    The path begins exactly at the start and ends exactly at the goal, including the heading. Its curvature never
    exceeds the curvature of the minimum turning radius. Poses always have the heading of the robot, also in reverse.
    All cells that the path crosses are free, and where it crosses diagonally from one cell to another, so are the two
    beside.

    Parameters
    ----------
    **parameters
        The fields of `ppaas.planners.lattice.parameters.LatticeParameters`.
    """

    name: ClassVar[str] = "lattice"
    purpose: ClassVar[str] = "Path for a robot that cannot turn on the spot: forward only, or backing up where it must."
    traits: ClassVar[Traits] = Traits(any_angle=True, kinematic=True)

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(LatticeParameters, self.name, parameters)
        _load_kernels()

    def plan(self, costmap: Costmap, request: PlanRequest) -> PlanResult:
        """Find a path.

        Raises
        ------
        InvalidInput
            A pose is not finite, or the tolerance or the timeout is negative.
        StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied, NoValidPath, PlanTimeout, PlanCancelled
        """
        parameters = self.parameters
        request = replace(request, timeout=min(request.timeout, parameters.max_planning_time))
        watch = Watch(request)
        watch.check()
        tolerant = replace(request, tolerance=max(request.tolerance, parameters.tolerance))
        ends = place_ends(costmap, tolerant, allow_unknown=parameters.allow_unknown, check=watch.check)
        legs, surface, expanded = self._search(costmap, request, ends, watch.check)
        points = _points(surface, legs, bool(len(ends.escape)))
        poses = _poses(costmap, points, request.start, ends.goal_pose)
        cells = _cells(points, costmap, request.start, ends)
        return PlanResult(
            cells=cells,
            poses=poses,
            cost=path_cost(costmap, cells),
            length=path_length(poses),
            expanded=expanded,
            seconds=watch.seconds(),
            planner=self.name,
        )

    def _search(
        self, costmap: Costmap, request: PlanRequest, ends: Ends, check: Callable[[], None]
    ) -> tuple[Floats, DrivingSurface, int]:
        """Return the legs of a path, the surface that they lie on, and the number of expanded nodes."""
        parameters = self.parameters
        start, goal = _in_cells(costmap, request.start), _in_cells(costmap, ends.goal_pose)
        surface = prepare_surface(costmap, start, parameters, check)
        _check_outline(costmap, surface, (start, goal), (request.start, ends.goal_pose))
        field = CostField(
            Costmap(surface.costs, costmap.info), np.array([ends.goal]), threads=request.threads, check=check
        )
        if not field.grow(ends.start):
            raise NoValidPath(_no_path_message(request, ends, parameters))
        field.grow()
        values = field.values()
        leaving = float(values[ends.start]) if len(ends.escape) else math.nan
        car = car_of(parameters, costmap.info.resolution)
        motions = motions_of(car, interpolated=parameters.allow_primitive_interpolation)
        search = HybridAStarSearch(surface, car, values, motions=motions, leaving=leaving, start=start, goal=goal)
        if not self._found(search, check):
            raise NoValidPath(_no_path_message(request, ends, parameters))
        legs = search.legs()
        if parameters.smooth_path:
            legs = smooth(surface, car, legs, check)
        return legs, surface, search.expanded

    def _found(self, search: HybridAStarSearch, check: Callable[[], None]) -> bool:
        """Return whether a path exists.

        The forward search alternates with a backward one, with equal numbers of nodes. If either is exhausted without
        a path, there is none; finding that out takes at most twice the effort of the cheaper search.

        Raises
        ------
        PlanTimeout
            No path was found within ``max_iterations`` nodes.
        """
        most = self.parameters.max_iterations if self.parameters.max_iterations > 0 else 1 << 62
        allowed = min(DOUBTFUL, most)
        outcome, backward = search.run(check, allowed), None
        while outcome == PAUSED and allowed < most:
            backward = backward or search.from_goal()
            if not search.has_path and backward.run(check, allowed) == EXHAUSTED:
                return False
            allowed = most if search.has_path else min(2 * allowed, most)
            outcome = search.run(check, allowed)
        if outcome == PAUSED and not search.has_path:
            raise PlanTimeout(
                f"no path found after {most} nodes; raise max_iterations, choose a nearer goal, or another heading at "
                "the goal"
            )
        return outcome != EXHAUSTED


@cache
def _load_kernels() -> None:
    """Compile or load the kernels before the first request, whose time limit would else include compilation."""
    # Without compilation there is nothing to load, and plain Python would not wrap their hashes.
    if config.DISABLE_JIT:  # type: ignore[attr-defined]  # numba sets it from the environment
        return
    for kernels in (indexed_heap, reeds_shepp, dubins, driving, pose_tree, steering, hybrid_astar, shortcuts):
        kernels.warm()
    cell = Costmap(np.zeros((1, 1), np.uint8), GridInfo(1.0, 1, 1))
    field = CostField(cell, np.zeros((1, 2), np.int64))
    field.grow((0, 0))
    field.values()


def _in_cells(costmap: Costmap, pose: Pose2D) -> Pose2D:
    info = costmap.info
    x, y, theta = info.origin.inverse() @ pose
    return Pose2D(x / info.resolution, y / info.resolution, theta)


def _points(surface: DrivingSurface, legs: Floats, leaving: bool) -> Floats:
    """Return the (n, 3) points x, y, theta along legs, in cells, less than a cell apart."""
    legs = legs[np.abs(legs[:, 4]) > MIN_LEG]
    count = sum(sample_count(surface, curvature, length) for curvature, length in legs[:, 3:5].tolist())
    points = np.empty((count, 3))
    trace(surface, legs, leaving, points)
    return points


def _poses(costmap: Costmap, points: Floats, start: Pose2D, goal: Pose2D) -> Poses:
    """Return the (n, 7) poses of a path with the given ends."""
    info = costmap.info
    cosine, sine = math.cos(info.origin.theta), math.sin(info.origin.theta)
    x, y = points[:, 0] * info.resolution, points[:, 1] * info.resolution
    flat = np.empty((len(points) + 1, 3))
    flat[0] = start
    flat[1:, 0] = info.origin.x + cosine * x - sine * y
    flat[1:, 1] = info.origin.y + sine * x + cosine * y
    flat[1:, 2] = points[:, 2] + info.origin.theta
    flat[-1] = goal
    poses = np.zeros((len(flat), 7))
    poses[:, :2] = flat[:, :2]
    poses[:, 5], poses[:, 6] = np.sin(flat[:, 2] / 2.0), np.cos(flat[:, 2] / 2.0)
    return poses


def _cells(points: Floats, costmap: Costmap, start: Pose2D, ends: Ends) -> NDArray[np.int32]:
    """Return the (n, 2) cells that contain the points, without consecutive duplicates."""
    first = costmap.info.to_cells((start.x, start.y))
    cells = np.vstack((first, np.floor(points[:, 1::-1]))).astype(np.int32)
    cells[-1] = ends.goal
    moved = np.any(np.diff(cells, axis=0) != 0, axis=1)
    return cells[np.concatenate(([True], moved))]


def _check_outline(
    costmap: Costmap, surface: DrivingSurface, ends: tuple[Pose2D, Pose2D], poses: tuple[Pose2D, Pose2D]
) -> None:
    """Raise if the outline touches an obstacle at either end; the error states the poses in the frame of the map."""
    (start, goal), (start_pose, goal_pose) = ends, poses
    if not len(surface.corners):
        return
    if not fits(surface, start.x, start.y, math.cos(start.theta), math.sin(start.theta)):
        raise StartOccupied(
            f"the footprint at the start {_format_pose(start_pose)} touches "
            f"{cause_text(costmap, start_pose, 'an obstacle')}; correct the pose or the footprint"
        )
    if not fits(surface, goal.x, goal.y, math.cos(goal.theta), math.sin(goal.theta)):
        raise GoalOccupied(
            f"the footprint would touch {cause_text(costmap, goal_pose, 'an obstacle')} at the goal "
            f"{_format_pose(goal_pose)}; choose another pose"
        )


def _format_pose(pose: Pose2D) -> str:
    return f"x={pose.x:.3f} y={pose.y:.3f} yaw={wrap_angle(pose.theta):.3f}"


def _no_path_message(request: PlanRequest, ends: Ends, parameters: LatticeParameters) -> str:
    hint = (
        "allow driving in reverse (motion_model_for_search: REEDS_SHEPP), "
        if parameters.motion_model_for_search == DUBIN
        else ""
    )
    return (
        f"no free path from {_format_pose(request.start)} to {_format_pose(ends.goal_pose)} for a turning radius of "
        f"{parameters.minimum_turning_radius} m; {hint}clear the costmap, or choose another goal or heading"
    )
