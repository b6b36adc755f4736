"""Buildings of users, with their versions: records, and the port of stores of them.

The port follows the rules of ``storage.ports``.
"""

from collections.abc import Iterable
from typing import Protocol

import msgspec
from msgspec.structs import replace

from ppaas.buildings.building import Building, json_of
from ppaas.errors import Conflict, InvalidInput, NotFound

MOST_FORMER = 50
"""Largest number of former versions of a building that are kept."""

FORMER_BYTES = 512 * 1024
"""Size of the former versions of a building up to which they are kept, as JSON [bytes]."""


class BuildingVersion(msgspec.Struct, frozen=True, kw_only=True):
    """A version of a building.

    Parameters
    ----------
    number : int
        Rises by one from version to version; the first is 1.
    building : Building
    author : str
        User who made it.
    created : float
        [s since the epoch]
    message : str
        Reason of the change.
    """

    number: int
    building: Building
    author: str
    created: float
    message: str = ""


class BuildingRecord(msgspec.Struct, frozen=True, kw_only=True):
    """A building of a user, in all versions that are kept.

    Parameters
    ----------
    user, id : str
    present : BuildingVersion
        The current version.
    former : tuple of BuildingVersion
        Those before it, newest first.
    readers : tuple of str
        Users who may see it; ``"*"`` among them makes it public.
    """

    user: str
    id: str
    present: BuildingVersion
    former: tuple[BuildingVersion, ...] = ()
    readers: tuple[str, ...] = ()

    @property
    def key(self) -> tuple[str, str]:
        """User and id."""
        return self.user, self.id

    @property
    def building(self) -> Building:
        """The building in its current version."""
        return self.present.building

    def readable_by(self, user: str) -> bool:
        """Return whether a user may see the building."""
        return user == self.user or user in self.readers or "*" in self.readers

    def version(self, number: int) -> BuildingVersion:
        """Return a version; ``NotFound`` if it was never made, or is not kept any more."""
        for version in (self.present, *self.former):
            if version.number == number:
                return version
        raise NotFound(f"version of building {self.id!r}:", str(number))

    def followed_by(self, version: BuildingVersion) -> "BuildingRecord":
        """Return the record with a version after the current one; the oldest are dropped beyond the limits."""
        former: list[BuildingVersion] = []
        size = 0
        for each in (self.present, *self.former)[:MOST_FORMER]:
            size += len(json_of(each.building))
            if size > FORMER_BYTES:
                break
            former.append(each)
        return replace(self, present=replace(version, number=self.present.number + 1), former=tuple(former))

    def changed_meanwhile(self) -> Conflict:
        """Return the error of a building that another process changed, added or removed first."""
        return Conflict(f"building {self.id!r} has been changed meanwhile: read it again and retry")


def no_building(building: str) -> NotFound:
    """Return the error of a building that does not exist."""
    return NotFound("building", building)


class BuildingStore(Protocol):
    """Buildings of users; two users may have buildings of the same id."""

    def put_building(self, record: BuildingRecord, *, instead_of: BuildingRecord | None = None) -> None:
        """Store a building in place of another record of it, or as a new one.

        Raises
        ------
        Conflict
            The stored record is not ``instead_of``, or there is one though None is given: another process was first.
        """
        ...

    def building(self, user: str, building: str) -> BuildingRecord:
        """Return a building; ``NotFound`` if it does not exist."""
        ...

    def buildings(self, user: str, *, after: str = "", limit: int | None = None) -> list[BuildingRecord]:
        """Return the buildings of a user, sorted by id."""
        ...

    def building_users(self) -> list[str]:
        """Return the users who have buildings, sorted."""
        ...

    def remove_building(self, user: str, building: str, *, instead_of: BuildingRecord | None = None) -> None:
        """Remove a building with all versions.

        Raises
        ------
        NotFound
            It does not exist.
        Conflict
            ``instead_of`` is given and differs from the stored record: another process changed it first.
        """
        ...


def all_buildings(store: BuildingStore) -> list[BuildingRecord]:
    """Return the buildings of all users; may block."""
    return [record for user in store.building_users() for record in store.buildings(user)]


def building_with_map(records: Iterable[BuildingRecord], user: str, map_id: str) -> BuildingRecord | None:
    """Return the building that a map is a floor of, among those that a user may see, the user's own one first."""
    for record in sorted(records, key=lambda record: (record.user != user, record.key)):
        if record.readable_by(user) and record.building.floor_of_map(map_id) is not None:
            return record
    return None


def no_building_of(map_id: str) -> InvalidInput:
    """Return the error of a map that is no floor of a building."""
    return InvalidInput(f"map {map_id!r} is no floor of a building of yours: put one with 'ppaas building'")
