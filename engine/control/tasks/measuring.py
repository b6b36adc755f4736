"""Lengths of the ways between the robots and the tasks of an area, by planning containers."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import NamedTuple

from engine.control.journeys.calls import TaskJourneys
from engine.control.planning.building_requests import BuildingSpot
from engine.control.planning.requests import CostAnswer, CostRequest
from engine.control.tasks.areas import TaskArea
from engine.control.tasks.task_maps import TaskMap, distance_by
from engine.specs.containers import MapVersion
from ppaas.errors import PPaaSError
from ppaas.tasks.assignment import Distance
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.floors import bare, floor_of
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Place
from ppaas.tasks.ways import ways_by_times

logger = logging.getLogger(__name__)

TIMEOUT = 4.0
"""Time to wait for the costs [s]; a decision that comes later is worse than one by distances in a straight line."""

Costs = Callable[[str, MapVersion, CostRequest], Awaitable[CostAnswer]]
"""Computes the costs for a user on a version of a map."""


class AreaWays(NamedTuple):
    """Measures the ways of an area; straight lines if no planning container answers in time.

    A way near obstacles counts as longer, by its cost. Between floors, a way is as long as what is driven in its time.

    Parameters
    ----------
    costs : callable
        Computes a matrix of costs.
    journeys : TaskJourneys, optional
        Knows the ways over floors.
    area : TaskArea
    maps : mapping of str to TaskMap
        Maps of the area, by floor.
    """

    costs: Costs
    journeys: TaskJourneys | None
    area: TaskArea
    maps: Mapping[str, TaskMap]

    async def measure(self, dispatcher: Dispatcher, now: float) -> Distance:
        """Return the lengths of the ways from the robots of a dispatcher to its tasks."""
        tasks = dispatcher.undecided(now)
        starts = tuple(dict.fromkeys(candidate.place for candidate in dispatcher.candidates(now)))
        goals = tuple(dict.fromkeys(task.target for task in tasks))
        try:
            async with asyncio.timeout(TIMEOUT):
                if self.journeys is not None and any(task.floors for task in tasks):
                    return await self._over_floors(self.journeys, starts, goals)
                return await self._on_floors(starts, goals)
        except (PPaaSError, TimeoutError) as error:
            logger.debug("tasks on maps %r are assigned by straight lines: %s", self.area.maps, error)
            return straight

    async def _over_floors(
        self, journeys: TaskJourneys, starts: tuple[Place, ...], goals: tuple[Place, ...]
    ) -> Distance:
        [(user, any_map), *_] = self.area.groups
        seconds = await journeys.times(user, any_map, list(map(_spot, starts)), list(map(_spot, goals)))
        return ways_by_times(starts, goals, seconds)

    async def _on_floors(self, *ends: tuple[Place, ...]) -> Distance:
        """Return the lengths on each floor by itself."""
        parts = {floor: (_on(floor, ends[0]), _on(floor, ends[1])) for floor in self.maps}
        asked = [floor for floor, (starts, goals) in parts.items() if starts and goals]
        found = await asyncio.gather(*(self._on_floor(floor, *parts[floor]) for floor in asked))
        by_floor = dict(zip(asked, found, strict=True))
        return lambda start, goal: by_floor.get(floor_of(start), straight)(start, goal)

    async def _on_floor(self, floor: str, starts: tuple[Place, ...], goals: tuple[Place, ...]) -> Distance:
        on = self.maps[floor]
        if on.resolution is None:
            return straight
        request = CostRequest(tuple(map(bare, starts)), tuple(map(bare, goals)), TIMEOUT)
        answer = await self.costs(self.area.user, on.version, request)
        return distance_by(answer, starts, goals, on.resolution)


def _on(floor: str, places: tuple[Place, ...]) -> tuple[Place, ...]:
    return tuple(place for place in places if floor_of(place) == floor)


def _spot(place: Place) -> BuildingSpot:
    return BuildingSpot(floor_of(place), *bare(place))
