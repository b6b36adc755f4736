"""Areas of tasks: a map, or all floors of a building, on which one dispatcher leads the robots of a user."""

import asyncio
from typing import NamedTuple

from ppaas.buildings.building import Building
from storage.buildings.records import BuildingRecord, BuildingStore, all_buildings, building_with_map
from storage.names import Group

REREAD = 30.0
"""Time after which buildings are read again [s]."""


class TaskArea(NamedTuple):
    """Maps of a user on which tasks are led together.

    Parameters
    ----------
    user : str
    maps : tuple of (floor, map)
        Floors of a building with their maps; one map without a floor if that is of no building.
    """

    user: str
    maps: tuple[tuple[str, str], ...]

    @property
    def groups(self) -> list[Group]:
        """User and map of each floor."""
        return [(self.user, map_id) for _, map_id in self.maps]

    @property
    def has_floors(self) -> bool:
        """Whether it is a building."""
        return any(floor for floor, _ in self.maps)

    def map_on(self, floor: str) -> str:
        """Return the map of a floor."""
        return next(map_id for name, map_id in self.maps if name == floor)


def area_in(building: Building | None, group: Group) -> TaskArea:
    """Return the area of a user's map in the building that it is a floor of, if there is one."""
    user, map_id = group
    if building is None:
        return TaskArea(user, (("", map_id),))
    return TaskArea(user, tuple((floor.name, floor.map) for floor in building.floors))


class TaskAreas:
    """Knows which maps of users are floors of a building.

    Parameters
    ----------
    store : BuildingStore
    """

    def __init__(self, store: BuildingStore) -> None:
        self._store = store
        self._records: list[BuildingRecord] = []
        self._read_at = float("-inf")

    async def read(self, now: float) -> bool:
        """Read the buildings again, unless that was done a moment ago; return whether they were read."""
        is_due = now - self._read_at >= REREAD
        if is_due:
            self._records, self._read_at = await asyncio.to_thread(all_buildings, self._store), now
        return is_due

    def of(self, group: Group) -> TaskArea:
        """Return the area of a map of a user."""
        record = building_with_map(self._records, *group)
        return area_in(None if record is None else record.building, group)
