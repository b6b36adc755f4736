"""Zones of the maps of a fleet, read from the cloud from time to time."""

import logging
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ppaas.errors import PPaaSError
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import Zone, ZoneSet, ZonesInForce
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of

logger = logging.getLogger(__name__)

PERIOD = 10.0
"""Time between two looks at the zones of a map [s]."""


@dataclass(slots=True)
class _MapZones:
    zones: ZoneSet | None = None
    read_at: float = -math.inf
    in_force: ZonesInForce | None = None
    problem: str = ""


class ZoneReader:
    """Zones of maps.

    Parameters
    ----------
    rest : RestClient
    """

    def __init__(self, rest: RestClient) -> None:
        self._rest = rest
        self._maps: dict[str, _MapZones] = {}

    async def look(self, maps: Iterable[str], now: float) -> None:
        """Read the zones of the maps whose last look is `PERIOD` ago [s]; if that fails, the ones before stay."""
        wanted = set(maps)
        self._maps = {map_id: self._maps.get(map_id) or _MapZones() for map_id in wanted}
        for map_id, known in self._maps.items():
            if now - known.read_at >= PERIOD:
                known.read_at = now
                await self._read(map_id, known)

    async def _read(self, map_id: str, known: _MapZones) -> None:
        problem = ""
        try:
            zones = zones_of(await self._rest.fetch(path_of("maps", map_id, "zones")))
        except PPaaSError as error:
            problem = str(error)
        else:
            if zones != known.zones:
                known.zones, known.in_force = zones, ZonesInForce(zones)
        if problem and problem != known.problem:
            logger.warning("the zones of map %s cannot be read: %s", map_id, problem)
        known.problem = problem

    def in_force(self, map_id: str, now: float) -> Sequence[Zone] | None:
        """Return the zones of a map that are in force, the same object until others are; None if they are not known.

        Parameters
        ----------
        map_id : str
        now : float
            Time [s since the epoch].
        """
        known = self._maps.get(map_id)
        return None if known is None or known.in_force is None else known.in_force.at(now)
