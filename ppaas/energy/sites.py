"""Places of a map where robots charge and park: docks and stations among its zones."""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field

from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, LiftCar, Passage, Station, Zone, ZoneSet

Spot = tuple[float, float, float]
"""x, y [m], yaw [rad] in the frame of the map."""


@dataclass(frozen=True, slots=True)
class Sites:
    """Places where robots charge and park, by name.

    Parameters
    ----------
    chargers : mapping of str to Spot
    parking : mapping of str to Spot
    docks : mapping of str to str
        Names of the docks at which robots dock, on their maps, by the names of these chargers.
    linked : mapping of str to set of str
        In a building, the floors that lifts and ways lead to from each floor.
    """

    chargers: Mapping[str, Spot] = field(default_factory=dict)
    parking: Mapping[str, Spot] = field(default_factory=dict)
    docks: Mapping[str, str] = field(default_factory=dict)
    linked: Mapping[str, AbstractSet[str]] = field(default_factory=dict)

    def dock_at(self, place: Spot) -> str:
        """Return the name of the dock at a place; empty if no robot docks there."""
        return next((dock for name, dock in self.docks.items() if self.chargers.get(name) == place), "")

    def leads(self, here: str, there: str) -> bool:
        """Return whether robots get from a floor to another; of a map that is no floor, the names are empty."""
        return here == there or there in self.linked.get(here, ())


NO_SITES = Sites()


def sites_of(zones: ZoneSet) -> Sites:
    """Return where robots charge and park: docks that charge, and stations for these uses."""
    chargers = {zone.name: _spot(zone) for zone in zones.zones if _charges(zone)}
    parking = {
        zone.name: _spot(zone)
        for zone in zones.zones
        if isinstance(zone.rule, Station) and "park" in zone.rule.uses and zone.name not in chargers
    }
    docks = {zone.name: zone.name for zone in zones.zones if isinstance(zone.rule, Dock) and zone.name in chargers}
    return Sites(chargers, parking, docks)


def links_of(zones: ZoneSet) -> frozenset[str]:
    """Return the lifts and ways of a floor, by which robots leave it."""
    lifts = (zone.rule.lift or zone.name for zone in zones.zones if isinstance(zone.rule, LiftCar))
    return frozenset((*lifts, *(zone.rule.way for zone in zones.zones if isinstance(zone.rule, Passage))))


def _charges(zone: Zone) -> bool:
    rule = zone.rule
    return rule.charges if isinstance(rule, Dock) else isinstance(rule, Station) and "charge" in rule.uses


def _spot(zone: Zone) -> Spot:
    assert isinstance(zone.rule, Dock | Station) and isinstance(zone.geometry, Point), "marks of these kinds are points"
    x, y, *_ = zone.geometry.coordinates
    return x, y, zone.rule.yaw or 0.0
