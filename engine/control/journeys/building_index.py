"""Index of buildings by the maps of their floors, so that a goal on a floor does not read those of all users."""

from collections import defaultdict
from collections.abc import Iterable

from ppaas.clock import Clock, monotonic
from ppaas.errors import NotFound
from storage.buildings.records import BuildingRecord, BuildingStore

FRESH = 5.0
"""Age up to which the index is used [s]: for so long, a building that another process puts may be overlooked."""


class BuildingIndex:
    """Buildings by the maps of their floors. What it returns was read just then.

    Parameters
    ----------
    store : BuildingStore
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, store: BuildingStore, clock: Clock = monotonic) -> None:
        self._store, self._clock = store, clock
        self._keys: dict[str, list[tuple[str, str]]] = {}
        self._read_at = float("-inf")

    def with_floor(self, user: str, map_id: str) -> BuildingRecord | None:
        """Return the building that a map is a floor of; None if there is none; may block.

        Parameters
        ----------
        user : str
            User who must be able to read it; the user's own building is preferred to those of others.
        map_id : str
        """
        if self._clock() - self._read_at <= FRESH:
            found = self._first(user, map_id)
            if found is not None:
                return found
        self._read()
        return self._first(user, map_id)

    def _first(self, user: str, map_id: str) -> BuildingRecord | None:
        keys: Iterable[tuple[str, str]] = self._keys.get(map_id, ())
        for key in sorted(keys, key=lambda each: each[0] != user):
            try:
                record = self._store.building(*key)
            except NotFound:
                continue
            if record.readable_by(user) and record.building.floor_of_map(map_id) is not None:
                return record
        return None

    def _read(self) -> None:
        began, found = self._clock(), defaultdict[str, list[tuple[str, str]]](list)
        for record in (each for owner in self._store.building_users() for each in self._store.buildings(owner)):
            for floor in record.building.floors:
                found[floor.map].append(record.key)
        self._keys, self._read_at = dict(found), began
