"""Places of a map where robots charge and park: docks and stations among its zones."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, Station, Zone, ZoneSet

Spot = tuple[float, float, float]
"""x, y [m], yaw [rad] in the frame of the map."""


@dataclass(frozen=True, slots=True)
class Sites:
    """Places where robots charge and park, by name.

    Parameters
    ----------
    chargers : mapping of str to Spot
    parking : mapping of str to Spot
    docks : frozenset of str
        Chargers at which robots dock.
    """

    chargers: Mapping[str, Spot] = field(default_factory=dict)
    parking: Mapping[str, Spot] = field(default_factory=dict)
    docks: frozenset[str] = frozenset()

    def dock_at(self, place: Spot) -> str:
        """Return the name of the dock at a place; empty if no robot docks there."""
        return next((name for name in self.docks if self.chargers.get(name) == place), "")


NO_SITES = Sites()


def sites_of(zones: ZoneSet) -> Sites:
    """Return where robots charge and park: docks that charge, and stations for these uses."""
    chargers = {zone.name: _spot(zone) for zone in zones.zones if _charges(zone)}
    parking = {
        zone.name: _spot(zone)
        for zone in zones.zones
        if isinstance(zone.rule, Station) and "park" in zone.rule.uses and zone.name not in chargers
    }
    docks = frozenset(zone.name for zone in zones.zones if isinstance(zone.rule, Dock) and zone.name in chargers)
    return Sites(chargers, parking, docks)


def _charges(zone: Zone) -> bool:
    rule = zone.rule
    return rule.charges if isinstance(rule, Dock) else isinstance(rule, Station) and "charge" in rule.uses


def _spot(zone: Zone) -> Spot:
    assert isinstance(zone.rule, Dock | Station) and isinstance(zone.geometry, Point), "marks of these kinds are points"
    x, y, *_ = zone.geometry.coordinates
    return x, y, zone.rule.yaw or 0.0
