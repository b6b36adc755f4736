"""Buildings in memory."""

import threading

from storage.buildings.records import BuildingRecord, no_building
from storage.encoding import decode, encode
from storage.names import check_building_key, check_name


class MemoryBuildings:
    """A ``BuildingStore`` of a dictionary. They are stored as bytes, because a caller may change labels of ways."""

    def __init__(self) -> None:
        self._buildings_lock = threading.Lock()
        self._buildings: dict[tuple[str, str], bytes] = {}

    def put_building(self, record: BuildingRecord, *, instead_of: BuildingRecord | None = None) -> None:
        """Store a building; ``Conflict`` if the stored one is not ``instead_of``."""
        key, data = check_building_key(*record.key), encode(record)
        with self._buildings_lock:
            if self._building_or_none(key) != instead_of:
                raise record.changed_meanwhile()
            self._buildings[key] = data

    def building(self, user: str, building: str) -> BuildingRecord:
        """Return a building; ``NotFound`` if it does not exist."""
        key = check_building_key(user, building)
        with self._buildings_lock:
            found = self._building_or_none(key)
        if found is None:
            raise no_building(building)
        return found

    def buildings(self, user: str, *, after: str = "", limit: int | None = None) -> list[BuildingRecord]:
        """Return the buildings of a user, sorted by id."""
        check_name("user", user)
        with self._buildings_lock:
            keys = sorted(key for key in self._buildings if key[0] == user and key[1] > after)[:limit]
            return [decode(self._buildings[key], BuildingRecord) for key in keys]

    def building_users(self) -> list[str]:
        """Return the users who have buildings, sorted."""
        with self._buildings_lock:
            return sorted({user for user, _ in self._buildings})

    def remove_building(self, user: str, building: str, *, instead_of: BuildingRecord | None = None) -> None:
        """Remove a building; ``Conflict`` if ``instead_of`` is given and differs from the stored one."""
        key = check_building_key(user, building)
        with self._buildings_lock:
            found = self._building_or_none(key)
            if found is None:
                raise no_building(building)
            if instead_of is not None and found != instead_of:
                raise found.changed_meanwhile()
            del self._buildings[key]

    def _building_or_none(self, key: tuple[str, str]) -> BuildingRecord | None:
        data = self._buildings.get(key)
        return None if data is None else decode(data, BuildingRecord)

    def _forget_buildings(self, user: str) -> None:
        with self._buildings_lock:
            self._buildings = {key: data for key, data in self._buildings.items() if key[0] != user}
