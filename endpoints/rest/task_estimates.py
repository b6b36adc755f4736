"""Estimates of when a new task ends: a rehearsal of the tasks of its map with the robots that are connected."""

import asyncio
import time
from collections.abc import Mapping

from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.task_schemas import EstimateAnswer
from engine.control.planning.requests import CostRequest
from engine.control.tasks.areas import TaskArea
from engine.control.tasks.task_maps import distance_by, task_map_on
from engine.specs.containers import MapVersion
from ppaas.errors import PPaaSError
from ppaas.tasks.assignment import Distance, labels_of, worth
from ppaas.tasks.floors import bare, floor_of, on_floor
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Task
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


async def estimate(
    services: Services, version: MapVersion, area: TaskArea, record: MapTask, now: float
) -> EstimateAnswer | None:
    """Return when a stored task would begin and end; None if no robot can do it now, or if that takes long to find.

    Parameters
    ----------
    services : Services
    version : MapVersion
        Current version of the map.
    area : TaskArea
        The map, or all floors of its building.
    record : MapTask
        The task.
    now : float
        Time [s since the epoch].
    """
    floors = {map_id: floor for floor, map_id in area.maps}
    robots = await _robots(services, record.user, floors)
    if not robots:
        return None
    stored = await run_in_threadpool(_stored, services, area)
    task = replace(record.task, home=floors[record.map])
    tasks = _considered(stored, task, now)
    distance: Distance = straight
    if task.deadline is not None and not task.floors:
        distance = await _ways(services, record, version, task, robots)
    return await run_in_threadpool(_rehearsed, tasks, robots, distance, task, now)


def _stored(services: Services, area: TaskArea) -> list[Task]:
    return [
        replace(record.task, home=floor)
        for floor, map_id in area.maps
        for record in services.store.tasks(area.user, map_id)
    ]


async def _robots(services: Services, user: str, floors: Mapping[str, str]) -> dict[str, RobotNow]:
    """Return the connected robots of a user on maps, whose floors are given, that know where they are."""
    stored = await run_in_threadpool(services.store.robots, user)
    here = [robot for robot in stored if robot.map in floors]
    try:
        views = await services.cloud.robot_views([(robot.user, robot.id) for robot in here])
    except PPaaSError:  # without a master nobody knows where they are
        return {}
    return {
        robot.id: RobotNow(on_floor(view.report.pose, floors[robot.map]), labels_of(robot.properties))
        for robot, view in zip(here, views, strict=True)
        if view is not None and view.connected and view.report.pose is not None
    }


def _considered(stored: list[Task], task: Task, now: float) -> list[Task]:
    """Return a task with those that go before it, and those that have ended, on which it may depend."""
    others = [other for other in stored if other.is_open and other.id != task.id]
    others.sort(key=lambda other: (not other.robot, -worth(other, now), other.id))
    return [task, *others[:MOST_REHEARSED], *(other for other in stored if not other.is_open)]


async def _ways(
    services: Services, record: MapTask, version: MapVersion, task: Task, robots: Mapping[str, RobotNow]
) -> Distance:
    """Return the lengths of the ways of a task alone on its map: those of the others are straight lines."""
    resolution = (await run_in_threadpool(task_map_on, services.map_store, version)).resolution
    if resolution is None:
        return straight
    here = [robot.place for robot in robots.values() if robot.place and floor_of(robot.place) == task.home]
    places = task.stops
    ends = tuple(dict.fromkeys((*here, *places)))
    try:
        async with asyncio.timeout(WAYS_TIMEOUT):
            request = CostRequest(tuple(map(bare, ends)), tuple(map(bare, places)), WAYS_TIMEOUT)
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
