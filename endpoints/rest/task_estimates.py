"""Estimates of when a new task ends: a rehearsal of the tasks of its map with the robots that are connected."""

import asyncio
import time

from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.task_schemas import EstimateAnswer
from engine.control.planning.requests import CostRequest
from engine.control.tasks.task_maps import distance_by, task_map_on
from engine.specs.containers import MapVersion
from ppaas.errors import PPaaSError
from ppaas.tasks.assignment import Distance, labels_of, worth
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Place, Task
from ppaas.tasks.rehearsal import Rehearsal
from storage.records import MapTask

MOST_REHEARSED = 32
"""Number of tasks before the new one that are rehearsed; others are worth less than these."""

HORIZON = 7 * 86400.0
"""Time until which a new task must end in a rehearsal [s]."""

LONGEST = 0.1
"""CPU time that a rehearsal may take [s], so that long patrols of many robots do not hold the endpoint up."""

WAYS_TIMEOUT = 1.0
"""Time to wait for the lengths of the ways of a task with a deadline [s]; then they are straight lines."""


async def estimate(services: Services, version: MapVersion, record: MapTask, now: float) -> EstimateAnswer | None:
    """Return when a stored task would begin and end; None if no robot can do it now, or if that takes long to find.

    Parameters
    ----------
    services : Services
    version : MapVersion
        Current version of the map.
    record : MapTask
        The task.
    now : float
        Time [s since the epoch].
    """
    robots = await _robots(services, record)
    if not robots:
        return None
    stored = await run_in_threadpool(services.store.tasks, record.user, record.map)
    tasks = _considered([other.task for other in stored], record.task, now)
    distance: Distance = straight
    if record.task.deadline is not None:
        distance = await _ways(services, record, version, [robot.place for robot in robots.values() if robot.place])
    return await run_in_threadpool(_rehearsed, tasks, robots, distance, record.task, now)


async def _robots(services: Services, record: MapTask) -> dict[str, RobotNow]:
    """Return the connected robots of the task's user on its map that know where they are."""
    stored = await run_in_threadpool(services.store.robots, record.user)
    here = [robot for robot in stored if robot.map == record.map]
    try:
        views = await services.cloud.robot_views([(robot.user, robot.id) for robot in here])
    except PPaaSError:  # without a master nobody knows where they are
        return {}
    return {
        robot.id: RobotNow(view.report.pose, labels_of(robot.properties))
        for robot, view in zip(here, views, strict=True)
        if view is not None and view.connected and view.report.pose is not None
    }


def _considered(stored: list[Task], task: Task, now: float) -> list[Task]:
    """Return a task with those that go before it, and those that have ended, on which it may depend."""
    others = [other for other in stored if other.is_open and other.id != task.id]
    others.sort(key=lambda other: (not other.robot, -worth(other, now), other.id))
    return [task, *others[:MOST_REHEARSED], *(other for other in stored if not other.is_open)]


async def _ways(services: Services, record: MapTask, version: MapVersion, starts: list[Place]) -> Distance:
    """Return the lengths of the ways of a task alone: those of the others are straight lines."""
    resolution = (await run_in_threadpool(task_map_on, services.map_store, version)).resolution
    if resolution is None:
        return straight
    places = record.task.places
    ends = tuple(dict.fromkeys((*starts, *places)))
    try:
        async with asyncio.timeout(WAYS_TIMEOUT):
            request = CostRequest(ends, places, WAYS_TIMEOUT)
            answer = await services.cloud.planning.compute_costs(record.user, version, request)
    except (PPaaSError, TimeoutError):
        return straight
    return distance_by(answer, ends, places, resolution)


def _rehearsed(
    tasks: list[Task], robots: dict[str, RobotNow], distance: Distance, task: Task, now: float
) -> EstimateAnswer | None:
    rehearsal = Rehearsal(tasks, robots, distance, now)
    ends_at = time.thread_time() + LONGEST
    rehearsal.run(now + HORIZON, lambda: not rehearsal.tasks[task.id].is_open or time.thread_time() > ends_at)
    found = rehearsal.tasks[task.id]
    if found.state != "done" or found.begun is None or found.ended is None:
        return None
    late = task.deadline is not None and found.ended > task.deadline
    return EstimateAnswer(robot=found.robot, begin=found.begun, finish=found.ended, late=late)
