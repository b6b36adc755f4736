"""Lengths of ways on a map, by the costs that planners compute."""

import math
from collections.abc import Iterable, Sequence

from msgspec.structs import replace

from ppaas.tasks.assignment import Distance, TaskRobot, may_do
from ppaas.tasks.reach import SPEED, straight
from ppaas.tasks.records import Place, Task

COST_OF_CELL = 50.0
"""Cost of a free cell: ``ppaas.planners.weights.NEUTRAL``, which comes with numba."""


def free_length(cost: float, resolution: float) -> float:
    """Return the length of a path through free cells that has a cost [m], on cells of a size [m].

    A path near obstacles costs more than a free one of its length.
    """
    return cost * resolution / COST_OF_CELL


def ways_by(
    starts: Sequence[Place], goals: Sequence[Place], costs: Sequence[Sequence[float | None]], resolution: float
) -> Distance:
    """Return the lengths of the ways of a matrix of costs; between other places, straight lines.

    A way near obstacles counts as longer, by its cost.

    Parameters
    ----------
    starts, goals : sequence of Place
    costs : sequence of sequence of float or None
        A row for each start with the cost to each goal; None where there is no path.
    resolution : float
        Size of a cell of the map [m].
    """
    return _by(
        starts, goals, [[None if cost is None else free_length(cost, resolution) for cost in row] for row in costs]
    )


def ways_by_times(
    starts: Sequence[Place], goals: Sequence[Place], seconds: Sequence[Sequence[float | None]]
) -> Distance:
    """Return the lengths of ways over floors by the times that they take, with rides; as ``ways_by``.

    Parameters
    ----------
    starts, goals : sequence of Place
    seconds : sequence of sequence of float or None
        A row for each start with the time to each goal [s]; None where there is no way.
    """
    rows = [[None if each is None else each * SPEED for each in row] for row in seconds]
    return _by(starts, goals, rows)


def _by(starts: Sequence[Place], goals: Sequence[Place], lengths: Sequence[Sequence[float | None]]) -> Distance:
    known: dict[tuple[Place, Place], float] = {
        (start, goal): math.inf if length is None else length
        for start, row in zip(starts, lengths, strict=True)
        for goal, length in zip(goals, row, strict=True)
    }
    return lambda start, goal: known.get((start, goal), straight(start, goal))


NO_WAY = "no way leads there now from any robot that may do it"
"""Reason of a task over floors for which no robot comes into question."""


def with_way_reasons(tasks: Iterable[Task], robots: Sequence[TaskRobot], distance: Distance) -> list[Task]:
    """Return the tasks over floors without a robot whose reason changes: whether a way leads there from any robot."""
    found = []
    for task in tasks:
        if task.floors and not task.robot and (reason := _way_reason(task, robots, distance)) != task.reason:
            found.append(replace(task, reason=reason))
    return found


def _way_reason(task: Task, robots: Sequence[TaskRobot], distance: Distance) -> str:
    able = [robot.place for robot in robots if may_do(task, robot.robot, robot.labels, robot.place)]
    if able and all(math.isinf(distance(place, task.target)) for place in able):
        return task.reason or NO_WAY
    return "" if task.reason == NO_WAY else task.reason
