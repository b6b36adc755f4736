"""Assignment of tasks to robots: costs of each pair, the cheapest pairs, and changes only if they pay."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.energy.battery import Battery
from ppaas.energy.sites import NO_SITES, Sites
from ppaas.people.tracks.hungarian import least_cost
from ppaas.tasks.floors import floor_of
from ppaas.tasks.reach import SPEED, lasts
from ppaas.tasks.records import PAYLOAD, Place, Task

PRIORITY = 120.0
"""Time of driving that one step of priority is worth [s]. A task that has waited for so long goes like a new one of the
next priority, so that no task starves."""

URGENT = 300.0
"""Time before its deadline from which a task is more urgent than others [s]."""

URGENCY = 4.0
"""Weight of the part of that time that has passed."""

MARGIN = 10.0
"""Time of driving that a change must save for each task that another robot takes over [s]."""

MOST_TASKS = 128
"""Number of tasks that are considered at once: those that are worth most."""

Array = NDArray[np.float64]
Distance = Callable[[Place, Place], float]
"""Returns the length of the way between two places [m]; infinite if there is none."""


@dataclass(frozen=True, slots=True)
class TaskRobot:
    """A robot that may do tasks.

    Parameters
    ----------
    robot : str
    place : Place
        Where it is; for a robot with a task that it keeps, the last place of that task.
    remaining : float
        Time until it is there [s]; 0 for a robot that may begin at once.
    labels : mapping of str to str
    battery : Battery, optional
        Its battery; None if it is not known.
    """

    robot: str
    place: Place
    remaining: float = 0.0
    labels: Mapping[str, str] = field(default_factory=dict)
    battery: Battery | None = None


def worth(task: Task, now: float) -> float:
    """Return for how much longer a robot may drive to a task than to a new one of priority 0 [s]."""
    left = math.inf if task.deadline is None else max(0.0, task.deadline - now)
    return PRIORITY * task.priority + max(0.0, now - task.may_start) + URGENCY * max(0.0, URGENT - left)


def may_do(task: Task, robot: str, labels: Mapping[str, str], place: Place | None = None) -> bool:
    """Return whether a robot with these labels, at this place, may do a task; over floors, if the task names floors."""
    if place is not None and not task.floors and floor_of(place) != task.home:
        return False
    if task.named_robot not in {"", robot} or (task.weight > 0.0 and not task.weight <= payload_of(labels)):
        return False
    return all(labels.get(name) == value for name, value in task.labels.items())


def labels_of(properties: Mapping[str, Any]) -> dict[str, str]:
    """Return the properties of a robot that tasks may require: texts, and numbers and truths as in JSON."""
    return {
        name: value if isinstance(value, str) else msgspec.json.encode(value).decode()
        for name, value in properties.items()
        if isinstance(value, str | int | float | bool)
    }


def payload_of(labels: Mapping[str, str]) -> float:
    """Return the weight that a robot with these labels can load [kg]; 0 if they do not have it."""
    try:
        return float(labels.get(PAYLOAD, 0.0))
    except ValueError:
        return 0.0


def costs_of(
    robots: Sequence[TaskRobot], tasks: Sequence[Task], distance: Distance, now: float, sites: Sites = NO_SITES
) -> Array:
    """Return the cost of each robot for each task [s]; infinite where it may not do it, or cannot.

    A task that has a robot is not handed over to one that is still busy.
    """
    costs = np.full((len(robots), len(tasks)), np.inf)
    for row, robot in enumerate(robots):
        for column, task in enumerate(tasks):
            waits = robot.remaining > 0.0 and task.robot not in {"", robot.robot}
            if may_do(task, robot.robot, robot.labels, robot.place) and not waits:
                way = distance(robot.place, task.target)
                if lasts(task, way + robot.remaining * SPEED, robot.battery, sites):
                    costs[row, column] = robot.remaining + way / SPEED - worth(task, now)
    return costs


def cheapest(costs: Array) -> list[tuple[int, int]]:
    """Return the rows and columns of as many pairs as possible; of those, the pairs whose sum of costs is least."""
    possible = np.isfinite(costs)
    if not possible.any():
        return []
    low, high = float(costs[possible].min()), float(costs[possible].max())
    never = (high - low + 1.0) * (min(costs.shape) + 1)  # more than any choice of possible pairs can save
    pairs = zip(*least_cost(np.where(possible, costs - low, never)), strict=True)
    return [(int(row), int(column)) for row, column in pairs if possible[row, column]]


def assign(
    robots: Sequence[TaskRobot], tasks: Sequence[Task], distance: Distance, now: float, sites: Sites = NO_SITES
) -> dict[str, str]:
    """Return which robot does which task, by task.

    Tasks of other robots that have not begun are handed over only if that saves ``MARGIN`` for each of them, so that
    robots do not turn back and forth.

    Parameters
    ----------
    robots : sequence of TaskRobot
        Robots that may begin a task now or later.
    tasks : sequence of Task
        Tasks that no robot has begun; ``robot`` is the one that drives to it.
    distance : callable
        Returns the length of a way.
    now : float
        Time [s since the epoch].
    sites : Sites
        Chargers, to which robots must get after the task.
    """
    chosen = _most_worth(tasks, now)
    costs = costs_of(robots, chosen, distance, now, sites)
    rows = {robot.robot: row for row, robot in enumerate(robots)}
    kept = [(rows[task.robot], column) for column, task in enumerate(chosen) if task.robot in rows]
    kept = [pair for pair in kept if math.isfinite(costs[pair])]
    best, usual = cheapest(costs), _beside(costs, kept)
    changed = len(set(kept) - set(best))
    pays = len(best) > len(usual) or _sum(costs, usual) - _sum(costs, best) >= MARGIN * changed
    return {chosen[column].id: robots[row].robot for row, column in (best if pays else usual)}


def _most_worth(tasks: Sequence[Task], now: float) -> list[Task]:
    return sorted(tasks, key=lambda task: (not task.robot, -worth(task, now), task.id))[:MOST_TASKS]


def _beside(costs: Array, kept: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return pairs that are kept, and the cheapest ones of the other robots and tasks."""
    rest = costs.copy()
    for row, column in kept:
        rest[row, :] = rest[:, column] = np.inf
    return [*kept, *cheapest(rest)]


def _sum(costs: Array, pairs: list[tuple[int, int]]) -> float:
    return sum(float(costs[pair]) for pair in pairs)
