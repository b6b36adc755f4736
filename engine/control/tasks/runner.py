"""Runner of tasks: leads the tasks of all users and maps, in the process of the master."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Callable
from functools import partial

from engine.control.journeys.calls import TaskJourneys
from engine.control.tasks.areas import TaskArea, TaskAreas, area_in
from engine.control.tasks.group import KEPT_FOR, Changed, Measure, TaskGroup
from engine.control.tasks.measuring import AreaWays, Costs
from engine.control.tasks.robots import TaskRobots
from engine.control.tasks.task_maps import TaskMap, sites_on_floors
from engine.processes.background import repeat
from engine.specs.containers import MapVersion
from ppaas.clock import Clock, epoch
from ppaas.errors import NotFound
from ppaas.tasks.assignment import Distance, labels_of
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.reach import straight
from ppaas.tasks.records import TaskState
from storage.names import Group
from storage.ports import Store

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


async def no_ways(_dispatcher: Dispatcher, _now: float) -> Distance:
    """Return straight lines: without robots there is nothing to measure."""
    return straight


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
    journeys : TaskJourneys, optional
        Leads robots over the floors of buildings; without it, each map is led by itself.
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
        journeys: TaskJourneys | None = None,
        changed: Changed = lambda _user, _map, _task: None,
        kept_for: float = KEPT_FOR,
        task_map: Callable[[MapVersion], TaskMap] = TaskMap,
    ) -> None:
        self._store = store
        self._robots = robots
        self._news = news
        self._costs = costs
        self._clock = clock
        self._journeys = journeys
        self._areas = TaskAreas(store) if journeys is not None else None
        self._lead_group = partial(TaskGroup, store=store, robots=robots, changed=changed, journeys=journeys)
        self._kept_for = kept_for
        self._read_map = task_map
        self._maps: dict[Group, TaskMap] = {}
        self._groups: dict[TaskArea, TaskGroup] = {}
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
        await self._note_news(now)
        self._groups = {key: group for key, group in self._groups.items() if group.is_open(now)}
        if not self._groups:
            self._robots.follow_only(set())
            return  # a cloud of many robots and no tasks need not look at each of them
        connected = self._robots.connected()
        there = {(user, robot) for (user, _), robots in connected.items() for robot in robots}
        self._labels = {key: read for key, read in self._labels.items() if key in there}
        self._robots.follow_only({group for area in self._groups for group in area.groups})
        led = [self._lead(group, connected, now) for group in self._groups.values()]
        for error in await asyncio.gather(*led, return_exceptions=True):
            if isinstance(error, BaseException):
                raise error

    async def _note_news(self, now: float) -> None:
        """Note changed tasks; those of a building that was changed are led by another group from now on."""
        if self._areas is not None and (self._groups or self._news.groups) and await self._areas.read(now):
            for area in [area for area in self._groups if any(self._area_of(group) != area for group in area.groups)]:
                del self._groups[area]
                self._news.groups.update(area.groups)
        while self._news.groups:
            area = self._area_of(self._news.groups.pop())
            self._groups.setdefault(area, self._lead_group(area, kept_for=self._kept_for)).changed = True

    def _area_of(self, group: Group) -> TaskArea:
        return area_in(None, group) if self._areas is None else self._areas.of(group)

    async def _find_chargers(self) -> None:
        """Lead robots also where there were no tasks, if their map has chargers."""
        connected, led = self._robots.connected(), {group for area in self._groups for group in area.groups}
        self._maps = {key: known for key, known in self._maps.items() if key in connected or key in led}
        for key in connected.keys() - led:
            if (await self._map_of(key, connected)).sites.chargers:
                self._news.groups.add(key)

    def open_tasks(self) -> Counter[TaskState]:
        """Return the numbers of tasks that have not ended, by state, as this process knows them."""
        return Counter(task.state for group in self._groups.values() for task in group.open_tasks())

    async def _lead(self, group: TaskGroup, here: dict[Group, dict[str, MapVersion]], now: float) -> None:
        area = group.area
        floors = {
            robot: floor for floor, map_id in area.maps for robot in here.get((area.user, map_id), {})
        }  # fmt: skip
        labels = {robot: await self._labels_of(area.user, robot, now) for robot in sorted(floors)}
        measure: Measure = no_ways
        if floors:
            maps = {floor: await self._map_of((area.user, name), here) for floor, name in area.maps}
            group.sites = sites_on_floors(maps)
            measure = AreaWays(self._costs, self._journeys, area, maps).measure
        await group.step(labels, now, measure, floors)

    async def _map_of(self, group: Group, here: dict[Group, dict[str, MapVersion]]) -> TaskMap:
        """Return a map as the robots there have it; where there are none, as they had it, or as it is."""
        known = self._maps.get(group)
        version = next(iter(here.get(group, {}).values()), MapVersion(group[1], "") if known is None else known.version)
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
