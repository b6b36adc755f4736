"""Buildings that a caller may read, and their layouts by the zones of the maps that the caller may read.

All functions here may block.
"""

from collections.abc import Iterator
from dataclasses import replace

from endpoints.resources.services import Services
from endpoints.rest.maps.maps import opened_map
from engine.rights.globs import split_address
from ppaas.buildings.building import Building
from ppaas.buildings.checks import warnings_of
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.errors import NotFound, NotPermitted
from ppaas.zones.zone import ZoneSet
from storage.buildings.records import BuildingRecord, BuildingStore, no_building
from storage.records import User
from storage.versions import ZONES


def readable_building(store: BuildingStore, user: User, address: str) -> BuildingRecord:
    """Return the building of an address, ``ID`` or ``OWNER:ID``.

    Raises
    ------
    NotFound
        It does not exist, or the user may not read it.
    """
    try:
        record = store.building(*split_address(address, user.id))
    except NotFound as error:
        raise no_building(address) from error
    if not reads_building(user, record):
        raise no_building(address)
    return record


def owned_building(store: BuildingStore, user: User, address: str) -> BuildingRecord:
    """Return the building of an address; ``NotPermitted`` unless the user owns it or is an administrator."""
    record = readable_building(store, user, address)
    if user.role != "admin" and user.id != record.user:
        raise NotPermitted(f"only the owner of building {address!r} may do this")
    return record


def readable_buildings(store: BuildingStore, user: User, after: tuple[str, str] = ("", "")) -> Iterator[BuildingRecord]:
    """Yield the buildings that a user may read, by owner and id, after a key of both."""
    for owner in store.building_users():
        if owner >= after[0]:
            found = store.buildings(owner, after=after[1] if owner == after[0] else "")
            yield from (record for record in found if reads_building(user, record))


def reads_building(user: User, record: BuildingRecord) -> bool:
    """Return whether a user may read a building; an administrator may read all."""
    return user.role == "admin" or record.readable_by(user.id)


def layout_for(services: Services, user: User, building: Building) -> BuildingLayout:
    """Return the layout of a building by the current zones of its maps, with all warnings.

    Floors whose map is removed, or may not be read by the user, are without places, and a warning names them.
    """
    zones: dict[str, ZoneSet] = {}
    unread = []
    for floor in building.floors:
        try:
            with opened_map(services, user, floor.map, only=(ZONES,)) as opened:
                zones[floor.name] = opened.zones()
        except NotFound:
            unread.append(f"floor {floor.name!r}: there is no map {floor.map!r} that you may read; it has no places")
    layout = layout_of(building, zones)
    return replace(layout, warnings=(*unread, *warnings_of(layout)))
