"""Runner of tasks: leads the tasks of all users and maps, in the process of the master."""

import asyncio
import contextlib
import logging
import math
from collections import Counter
from collections.abc import Awaitable, Callable
from functools import partial

from engine.control.planning.requests import CostAnswer, CostRequest
from engine.control.tasks.group import KEPT_FOR, Changed, TaskGroup
from engine.control.tasks.robots import TaskRobots
from engine.processes.background import repeat
from engine.specs.containers import MapVersion
from ppaas.clock import Clock, epoch
from ppaas.decoding import from_json
from ppaas.energy.sites import NO_SITES, Sites, sites_of
from ppaas.errors import NotFound, PPaaSError
from ppaas.tasks.assignment import Distance, labels_of
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Place, TaskState
from ppaas.zones.reading import zones_of
from storage.map_port import MapStore
from storage.names import Group
from storage.ports import Store
from storage.versions import ZONES

logger = logging.getLogger(__name__)


# -- lengths of the ways between robots and tasks ----------------------------------------------------------------------

TIMEOUT = 4.0
"""Time to wait for the costs [s]; a decision that comes later is worse than one by distances in a straight line."""

Costs = Callable[[str, MapVersion, CostRequest], Awaitable[CostAnswer]]
"""Computes the costs for a user on a version of a map."""


async def no_ways(_dispatcher: Dispatcher, _now: float) -> Distance:
    """Return straight lines: without robots there is nothing to measure."""
    return straight


async def ways(costs: Costs, user: str, version: MapVersion, dispatcher: Dispatcher, now: float) -> Distance:
    """Return the lengths of the ways from robots to tasks; straight lines if no planning container answers in time.

    Parameters
    ----------
    costs : callable
        Computes a matrix of costs.
    user : str
    version : MapVersion
    dispatcher : Dispatcher
        Has the robots and the tasks.
    now : float
        Time [s since the epoch].
    """
    starts = tuple(dict.fromkeys(candidate.place for candidate in dispatcher.candidates(now)))
    goals = tuple(dict.fromkeys(task.target for task in dispatcher.undecided(now)))
    try:
        async with asyncio.timeout(TIMEOUT):
            answer = await costs(user, version, CostRequest(starts, goals, TIMEOUT))
    except (PPaaSError, TimeoutError) as error:
        logger.debug("tasks on map %r are assigned by straight lines: %s", version.id, error)
        return straight
    rows = from_json(bytes(answer.costs), list[list[float | None]])
    known: dict[tuple[Place, Place], float] = {
        (start, goal): math.inf if cost is None else cost
        for start, row in zip(starts, rows, strict=True)
        for goal, cost in zip(goals, row, strict=True)
    }
    return lambda start, goal: known.get((start, goal), straight(start, goal))


# -- places where robots charge and park -------------------------------------------------------------------------------


def sites_on(maps: MapStore, version: MapVersion) -> Sites:
    """Return where robots charge and park on a version of a map; nowhere if it is removed or has no zones."""
    try:
        with maps.open_map(version.id, version.version, only=(ZONES,)) as opened:
            return sites_of(zones_of(bytes(opened.buffers[ZONES]))) if ZONES in opened.buffers else NO_SITES
    except NotFound:
        return NO_SITES


# -- all tasks ---------------------------------------------------------------------------------------------------------

PERIOD = 1.0
"""Time between two looks at robots and goals [s]; changed tasks and ended goals are a reason at once."""

PAUSE = 0.05
"""Least time between two looks [s]."""

SEARCH = 300.0
"""Time between two searches for users and maps with tasks without a notice that they were changed [s]."""

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
    sites : callable
        Returns where robots charge and park on a version of a map; it is called once for each, in a thread.
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
        sites: Callable[[MapVersion], Sites] = lambda _version: NO_SITES,
    ) -> None:
        self._store = store
        self._robots = robots
        self._news = news
        self._costs = costs
        self._clock = clock
        self._lead_group = partial(TaskGroup, store=store, robots=robots, changed=changed)
        self._kept_for = kept_for
        self._read_sites = sites
        self._sites: dict[Group, tuple[MapVersion, Sites]] = {}
        self._groups: dict[Group, TaskGroup] = {}
        self._labels: dict[tuple[str, str], tuple[float, dict[str, str]]] = {}
        self._searched_at = float("-inf")

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

    def open_tasks(self) -> Counter[TaskState]:
        """Return the numbers of tasks that have not ended, by state, as this process knows them."""
        return Counter(task.state for group in self._groups.values() for task in group.open_tasks())

    async def _lead(self, group: TaskGroup, robots: dict[str, MapVersion], now: float) -> None:
        user, _ = group.group
        labels = {robot: await self._labels_of(user, robot, now) for robot in sorted(robots)}
        if robots:
            group.sites = await self._sites_of(group.group, next(iter(robots.values())))
        measure = partial(ways, self._costs, user, next(iter(robots.values()))) if robots else no_ways
        await group.step(labels, now, measure)

    async def _sites_of(self, group: Group, version: MapVersion) -> Sites:
        known = self._sites.get(group)
        if known is None or known[0] != version:
            known = self._sites[group] = version, await asyncio.to_thread(self._read_sites, version)
        return known[1]

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
