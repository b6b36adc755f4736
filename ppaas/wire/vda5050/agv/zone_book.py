"""Sets of zones of an AGV, in 3.0: which it has, and which it uses."""

from ppaas.wire.vda5050.agv import faults
from ppaas.wire.vda5050.agv.faults import OrderRefused
from ppaas.wire.vda5050.states import ZoneSetState
from ppaas.wire.vda5050.zones import Zone, Zones
from ppaas.zones.validity import outline_fault

SUPPORTED = ("BLOCKED", "SPEED_LIMIT")
"""Types of zones that the cloud has masks for."""

MIN_SPEED = 0.02
"""Lowest limit of a zone [m/s]."""

FARTHEST = 10_000.0
"""Largest coordinate of a vertex [m]."""

MAX_SETS = 8
MAX_ZONES = 1000
MAX_VERTICES = 20_000
"""Largest numbers of sets, of zones of a set, and of vertices of a set."""


class ZoneBook:
    """Sets of zones.

    Parameters
    ----------
    map_id : str
        Map of the AGV.
    supported : tuple of str
        Types of zones that it respects.

    Attributes
    ----------
    enabled : str or None
        Id of the set in use.
    """

    def __init__(self, map_id: str, supported: tuple[str, ...]) -> None:
        self._map_id, self._supported = map_id, supported
        self._sets: dict[str, Zones] = {}
        self.enabled: str | None = None

    def add(self, zones: Zones) -> None:
        """Keep a set; it is not in use.

        Raises
        ------
        Refusal
            It is of another map, there already, too large, or has zones that cannot be respected.
        """
        ids = {"zoneSetId": zones.zone_set_id}
        if zones.map_id != self._map_id:
            raise OrderRefused(faults.UNKNOWN_MAP_ID, f"zones are on map {zones.map_id!r}, not {self._map_id!r}", ids)
        if zones.zone_set_id in self._sets:
            if zones == self._sets[zones.zone_set_id]:
                return
            raise OrderRefused(
                faults.DUPLICATE_ZONE_SET, f"zone set {zones.zone_set_id!r} is there: delete it before", ids
            )
        problem = _problem(zones, self._supported)
        if not problem and len(self._sets) >= MAX_SETS:
            problem = f"the robot has {MAX_SETS} zone sets: delete one"
        if problem:
            raise OrderRefused(faults.INVALID_ZONE_SET, problem, ids)
        self._sets[zones.zone_set_id] = zones

    def get(self, zone_set_id: str) -> Zones:
        """Return a set.

        Raises
        ------
        Refusal
            The AGV has no set of that id.
        """
        try:
            return self._sets[zone_set_id]
        except KeyError:
            text = f"there is no zone set {zone_set_id!r}; known: {', '.join(self._sets) or 'none'}"
            raise OrderRefused(faults.INVALID_ZONE_SET, text, {"zoneSetId": zone_set_id[: faults.MAX_TEXT]}) from None

    def remove(self, zone_set_id: str) -> None:
        """Forget a set that is not in use.

        Raises
        ------
        Refusal
            There is no such set, or it is in use.
        """
        self.get(zone_set_id)
        if self.enabled == zone_set_id:
            raise OrderRefused(
                faults.INVALID_ZONE_SET,
                f"zone set {zone_set_id!r} is in use: enable another one before",
                {"zoneSetId": zone_set_id},
            )
        del self._sets[zone_set_id]

    def states(self) -> list[ZoneSetState]:
        """Return the sets as the state has them."""
        return [
            ZoneSetState(
                zone_set_id=key,
                map_id=zones.map_id,
                zone_set_status="ENABLED" if key == self.enabled else "DISABLED",
            )
            for key, zones in self._sets.items()
        ]


def _problem(zones: Zones, supported: tuple[str, ...]) -> str:
    if not zones.zone_set_id:
        return "zoneSetId is empty"
    if len(zones.zones) > MAX_ZONES or sum(len(zone.vertices) for zone in zones.zones) > MAX_VERTICES:
        return f"a zone set has at most {MAX_ZONES} zones and {MAX_VERTICES} vertices"
    if any(max(abs(point.x), abs(point.y)) > FARTHEST for zone in zones.zones for point in zone.vertices):
        return f"a vertex is farther than {FARTHEST:g} m from the origin of the map"
    return next((problem for zone in zones.zones if (problem := _problem_of(zone, supported))), "")


def _problem_of(zone: Zone, supported: tuple[str, ...]) -> str:
    if zone.zone_type not in supported:
        return f"zone {zone.zone_id!r} is of type {zone.zone_type}; supported: {', '.join(supported) or 'none'}"
    if zone.zone_type == "SPEED_LIMIT" and not (zone.maximum_speed and zone.maximum_speed >= MIN_SPEED):
        return f"the maximumSpeed of zone {zone.zone_id!r} is not at least {MIN_SPEED} m/s"
    fault = outline_fault([(point.x, point.y) for point in zone.vertices])
    return f"zone {zone.zone_id!r}: {fault}" if fault else ""
