"""Gate for zones that are published: each is valid, mended with a word, or refused with the place."""

from typing import NamedTuple

import msgspec

from ppaas.maps.grid import GridInfo
from ppaas.zones.faults import Faults, Notes
from ppaas.zones.reading import read_zones
from ppaas.zones.shapes import Area
from ppaas.zones.validity import mended
from ppaas.zones.zone import NO_ZONES, Zone, ZoneSet

_OF_A_MACHINE = {"localtime", "posixrules", "Factory"}
"""Names in a time zone database that mean another zone on each computer, or none."""

_LEAPING = "right/"
"""Begin of the names of time zones whose clocks count leap seconds, as no computer's clock does."""


class CheckedZones(NamedTuple):
    """Zones that may be published, and warnings on what was mended in them or may be wrong."""

    zones: ZoneSet
    warnings: list[str]


def checked_zones(text: str | bytes, info: GridInfo | None = None, before: ZoneSet = NO_ZONES) -> CheckedZones:
    """Read the zones of a map that somebody gives.

    Parameters
    ----------
    text : str or bytes
        GeoJSON, read as `read_zones` does.
    info : GridInfo, optional
        Grid that they are on.
    before : ZoneSet
        Zones that they replace.

    Raises
    ------
    InvalidZones
        A zone is not valid; the text names all zones that are not, and the places.
    """
    read, notes = read_zones(text)
    faults = Faults()
    zones = [
        msgspec.structs.replace(zone, geometry=mended(zone.name, zone.geometry, faults, notes)) for zone in read.zones
    ]
    _check_time_zones(read, faults)
    faults.check()
    found = msgspec.structs.replace(read, zones=zones)
    if info is not None:
        _check_on_map(found, info, notes)
    _compare_time_zones(found, before, notes)
    return CheckedZones(found, notes.texts())


def check_on_map(zones: ZoneSet, info: GridInfo) -> list[str]:
    """Return warnings on zones of which a part is not on a grid.

    Raises
    ------
    InvalidZones
        A zone does not touch the grid; the text names all of them, and where they are.
    """
    notes = Notes()
    _check_on_map(zones, info, notes)
    return notes.texts()


def _check_on_map(zones: ZoneSet, info: GridInfo, notes: Notes) -> None:
    faults = Faults()
    for zone in zones.zones:
        _check_one(zone, info, faults, notes)
    faults.check()


def _check_one(zone: Zone, info: GridInfo, faults: Faults, notes: Notes) -> None:
    import shapely  # noqa: PLC0415 - only clouds and bridges have it

    corners = [(-0.5, -0.5), (-0.5, info.width - 0.5), (info.height - 0.5, info.width - 0.5), (info.height - 0.5, -0.5)]
    grid = shapely.Polygon(info.to_world(corners))
    area = zone.area
    parts = [*map(shapely.LineString, area.lines), *(shapely.Polygon(outer, holes) for outer, *holes in area.polygons)]
    parts += map(shapely.Point, area.point)
    half = 0.5 * zone.width
    off = [part for part in parts if part.distance(grid) > half]
    if len(off) == len(parts):
        box = f"{_range(area, 0)} × {_range(area, 1)}"
        advice = "are its positions longitudes and latitudes? They must be x, y in metres in the frame of the map"
        whole = f"zone {zone.name!r} is not on the map: it is at {box}; {advice}"
        faults.add(
            zone.name, f"it is not on the map: it is at {box}", (float(area.low[0]), float(area.low[1])), whole=whole
        )
    elif off:
        x, y = off[0].representative_point().coords[0]
        notes.add(f"a part at ({x:.6g}, {y:.6g}) is not on the map", zone.name)


def _range(area: Area, axis: int) -> str:
    return f"{area.low[axis]:.6g} to {area.high[axis]:.6g} m"


def _check_time_zones(zones: ZoneSet, faults: Faults) -> None:
    """Add faults for time zones that are not the same everywhere, or that count leap seconds."""
    for zone in zones.zones:
        name = zones.time_zone_of(zone)
        if zone.rule.times and (name in _OF_A_MACHINE or name.startswith(_LEAPING)):
            faults.add(zone.name, f"its time zone {name!r} is no place: give a name such as 'Europe/Berlin', or 'UTC'")


def _compare_time_zones(zones: ZoneSet, before: ZoneSet, notes: Notes) -> None:
    now, then = _time_zones(zones), _time_zones(before)
    if then and now - then:
        notes.add(
            f"times are in {', '.join(sorted(now - then))} now; those of the zones that are replaced are in "
            f"{', '.join(sorted(then))}"
        )


def _time_zones(zones: ZoneSet) -> set[str]:
    return {zones.time_zone_of(zone) for zone in zones.zones if zone.rule.times}
