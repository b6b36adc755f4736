"""Runner of tasks: leads the tasks of all users and maps, in the process of the master."""

import asyncio
import contextlib
import logging
from collections import Counter
from collections.abc import Awaitable, Callable
from functools import partial

from engine.control.planning.requests import CostAnswer, CostRequest
from engine.control.tasks.group import KEPT_FOR, Changed, Measure, TaskGroup
from engine.control.tasks.robots import TaskRobots
from engine.control.tasks.task_maps import TaskMap, distance_by
from engine.processes.background import repeat
from engine.specs.containers import MapVersion
from ppaas.clock import Clock, epoch
from ppaas.errors import NotFound, PPaaSError
from ppaas.tasks.assignment import Distance, labels_of
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.reach import straight
from ppaas.tasks.records import TaskState
from storage.names import Group
from storage.ports import Store

logger = logging.getLogger(__name__)


# -- lengths of the ways between robots and tasks ----------------------------------------------------------------------

TIMEOUT = 4.0
"""Time to wait for the costs [s]; a decision that comes later is worse than one by distances in a straight line."""

Costs = Callable[[str, MapVersion, CostRequest], Awaitable[CostAnswer]]
"""Computes the costs for a user on a version of a map."""


async def no_ways(_dispatcher: Dispatcher, _now: float) -> Distance:
    """Return straight lines: without robots there is nothing to measure."""
    return straight


async def ways(costs: Costs, user: str, on: TaskMap, dispatcher: Dispatcher, now: float) -> Distance:
    """Return the lengths of the ways from robots to tasks; straight lines if no planning container answers in time.

    A way near obstacles counts as longer, by its cost.

    Parameters
    ----------
    costs : callable
        Computes a matrix of costs.
    user : str
    on : TaskMap
        Version of the map.
    dispatcher : Dispatcher
        Has the robots and the tasks.
    now : float
        Time [s since the epoch].
    """
    starts = tuple(dict.fromkeys(candidate.place for candidate in dispatcher.candidates(now)))
    goals = tuple(dict.fromkeys(task.target for task in dispatcher.undecided(now)))
    if on.resolution is None:
        return straight
    try:
        async with asyncio.timeout(TIMEOUT):
            answer = await costs(user, on.version, CostRequest(starts, goals, TIMEOUT))
    except (PPaaSError, TimeoutError) as error:
        logger.debug("tasks on map %r are assigned by straight lines: %s", on.version.id, error)
        return straight
    return distance_by(answer, starts, goals, on.resolution)


# -- all tasks ---------------------------------------------------------------------------------------------------------

PERIOD = 1.0
"""Time between two looks at robots and goals [s]; changed tasks and ended goals are a reason at once."""

PAUSE = 0.05
"""Least time between two looks [s]."""

SEARCH = 300.0
"""Time between two searches for users and maps with tasks without a notice that they were changed [s]."""

LOOK = 10.0
"""Time between two looks for robots on maps with chargers for which there were no tasks [s]."""

LABELS = 30.0
"""Time after which the labels of robots are read again [s]."""


class TaskNews:
    """Collects the users and maps whose tasks were changed, and wakes the runner; implements ``TaskCalls``.

    Attributes
    ----------
    groups : set of Group
        Users and maps.
    wake : Event
        Set if there is something to do.
    """

    def __init__(self) -> None:
        self.groups: set[Group] = set()
        self.wake = asyncio.Event()

    async def changed(self, user: str, map_id: str) -> None:
        """Note that the tasks of a user on a map were changed in the store."""
        self.groups.add((user, map_id))
        self.wake.set()


class TaskRunner:
    """Leads the tasks of all users and maps until cancelled.

    Parameters
    ----------
    store : Store
        Has the tasks, and the robots' properties.
    robots : TaskRobots
    news : TaskNews
    costs : callable
        Computes costs of ways in a planning container.
    clock : callable
        Returns the time [s since the epoch].
    changed : callable
        Called with user, map and each task whose state has changed.
    kept_for : float
        Time for which a task is kept after its end [s].
    task_map : callable
        Returns what tasks need of a version of a map; it is called once for each, in a thread.
    """

    def __init__(
        self,
        store: Store,
        robots: TaskRobots,
        news: TaskNews,
        costs: Costs,
        clock: Clock = epoch,
        *,
        changed: Changed = lambda _user, _map, _task: None,
        kept_for: float = KEPT_FOR,
        task_map: Callable[[MapVersion], TaskMap] = TaskMap,
    ) -> None:
        self._store = store
        self._robots = robots
        self._news = news
        self._costs = costs
        self._clock = clock
        self._lead_group = partial(TaskGroup, store=store, robots=robots, changed=changed)
        self._kept_for = kept_for
        self._read_map = task_map
        self._maps: dict[Group, TaskMap] = {}
        self._groups: dict[Group, TaskGroup] = {}
        self._labels: dict[tuple[str, str], tuple[float, dict[str, str]]] = {}
        self._searched_at = self._looked_at = float("-inf")

    def keep_for(self, seconds: float) -> None:
        """Keep tasks for another time after their end [s]."""
        self._kept_for = seconds
        for group in self._groups.values():
            group.kept_for = seconds

    async def run(self) -> None:
        """Lead tasks until cancelled."""
        try:
            await repeat(self._when_due, PAUSE)
        finally:
            self._robots.close()

    async def _when_due(self) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(PERIOD):
                await self._news.wake.wait()
        self._news.wake.clear()
        await self.step()

    async def step(self) -> None:
        """Look at all users and maps with tasks once."""
        now = self._clock()
        if now - self._searched_at >= SEARCH:
            self._news.groups.update(await asyncio.to_thread(self._store.task_groups))
            self._searched_at = now
            self._robots.forget_closed()
        if now - self._looked_at >= LOOK:
            self._looked_at = now
            await self._find_chargers()
        while self._news.groups:
            group = self._news.groups.pop()
            self._groups.setdefault(group, self._lead_group(group, kept_for=self._kept_for)).changed = True
        self._groups = {key: group for key, group in self._groups.items() if group.is_open(now)}
        if not self._groups:
            self._robots.follow_only(set())
            return  # a cloud of many robots and no tasks need not look at each of them
        connected = self._robots.connected()
        there = {(user, robot) for (user, _), robots in connected.items() for robot in robots}
        self._labels = {key: read for key, read in self._labels.items() if key in there}
        self._robots.follow_only(set(self._groups))
        led = [self._lead(group, connected.get(key, {}), now) for key, group in self._groups.items()]
        for error in await asyncio.gather(*led, return_exceptions=True):
            if isinstance(error, BaseException):
                raise error

    async def _find_chargers(self) -> None:
        """Lead robots also where there were no tasks, if their map has chargers."""
        connected = self._robots.connected()
        self._maps = {key: known for key, known in self._maps.items() if key in connected or key in self._groups}
        for key, robots in connected.items():
            if key not in self._groups and (await self._map_of(key, next(iter(robots.values())))).sites.chargers:
                self._news.groups.add(key)

    def open_tasks(self) -> Counter[TaskState]:
        """Return the numbers of tasks that have not ended, by state, as this process knows them."""
        return Counter(task.state for group in self._groups.values() for task in group.open_tasks())

    async def _lead(self, group: TaskGroup, robots: dict[str, MapVersion], now: float) -> None:
        user, _ = group.group
        labels = {robot: await self._labels_of(user, robot, now) for robot in sorted(robots)}
        measure: Measure = no_ways
        if robots:
            on = await self._map_of(group.group, next(iter(robots.values())))
            group.sites = on.sites
            measure = partial(ways, self._costs, user, on)
        await group.step(labels, now, measure)

    async def _map_of(self, group: Group, version: MapVersion) -> TaskMap:
        known = self._maps.get(group)
        if known is None or known.version != version:
            known = self._maps[group] = await asyncio.to_thread(self._read_map, version)
        return known

    async def _labels_of(self, user: str, robot: str, now: float) -> dict[str, str]:
        read_at, labels = self._labels.get((user, robot), (float("-inf"), {}))
        if now - read_at >= LABELS:
            labels = await asyncio.to_thread(self._read_labels, user, robot)
            self._labels[user, robot] = now, labels
        return labels

    def _read_labels(self, user: str, robot: str) -> dict[str, str]:
        try:
            return labels_of(self._store.robot(user, robot).properties)
        except NotFound:
            return {}
