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
from ppaas.tasks.reach import RESERVE, SPEED, demand_of
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

_ANY = Battery(1e9, 0.0, 0.0)  # of robots whose batteries are not known

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


def may_do(task: Task, robot: str, labels: Mapping[str, str]) -> bool:
    """Return whether a robot with these labels may do a task."""
    if task.named_robot not in {"", robot} or (task.weight > 0.0 and not task.weight <= payload_of(labels)):
        return False
    return not task.labels or all(labels.get(name) == value for name, value in task.labels.items())


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
    if not robots or not tasks:
        return np.empty((len(robots), len(tasks)))
    ways, remaining = _ways(robots, tasks, distance), np.array([robot.remaining for robot in robots])
    for column, task in enumerate(tasks):
        able = [
            may_do(task, robot.robot, robot.labels) and (robot.remaining <= 0.0 or task.robot in {"", robot.robot})
            for robot in robots
        ]
        ways[np.logical_not(able), column] = np.inf
    if sites.chargers:
        driven = ways + remaining[:, np.newaxis] * SPEED
        ways[_charge_left(robots, tasks, driven, sites) < RESERVE] = np.inf
    costs: Array = remaining[:, np.newaxis] + ways / SPEED - np.array([worth(task, now) for task in tasks])
    return costs


def _ways(robots: Sequence[TaskRobot], tasks: Sequence[Task], distance: Distance) -> Array:
    """Return the lengths of the ways from robots to tasks [m], each measured once: many begin or end at one place."""
    starts = {robot.place: None for robot in robots}
    goals = {task.target: None for task in tasks}
    known: Array = np.array([[distance(start, goal) for goal in goals] for start in starts])
    rows, columns = ({place: number for number, place in enumerate(places)} for places in (starts, goals))
    found: Array = known[np.ix_([rows[robot.place] for robot in robots], [columns[task.target] for task in tasks])]
    return found


def _charge_left(robots: Sequence[TaskRobot], tasks: Sequence[Task], ways: Array, sites: Sites) -> Array:
    """Return the charge of each robot after each task and the way to a charger; much if its battery is not known."""
    demands = np.array([demand_of(task, sites) for task in tasks])
    batteries = [robot.battery or _ANY for robot in robots]
    numbers = np.array([(one.charge, one.per_metre, one.per_second) for one in batteries]).T
    charge, per_metre, per_second = numbers[..., np.newaxis]
    metres = ways + demands[:, 0]
    left: Array = charge - (per_metre * metres + per_second * (metres / SPEED + demands[:, 1]))
    return left


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
    pairs = cheapest(costs)
    changed = len(set(kept) - set(pairs))
    if changed:
        usual = _beside(costs, kept)
        pays = len(pairs) > len(usual) or _sum(costs, usual) - _sum(costs, pairs) >= MARGIN * changed
        pairs = pairs if pays else usual
    return {chosen[column].id: robots[row].robot for row, column in pairs}


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
