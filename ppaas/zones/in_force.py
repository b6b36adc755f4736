"""Zones in force, chosen again only when others may be."""

from collections.abc import Sequence

from ppaas.zones.zone import Zone, ZoneSet


class ZonesInForce:
    """Zones of a map that are in force at a time that goes on.

    Parameters
    ----------
    zones : ZoneSet
    """

    def __init__(self, zones: ZoneSet) -> None:
        self._zones = zones
        self._found: Sequence[Zone] | None = None
        self._until = float("-inf")

    def at(self, now: float) -> Sequence[Zone]:
        """Return the zones in force at a time [s since the epoch]: the same object as before until others are."""
        if self._found is None or now >= self._until:
            found, self._until = self._zones.in_force(now), self._zones.next_change(now)
            if found != self._found:
                self._found = found
        assert self._found is not None
        return self._found
