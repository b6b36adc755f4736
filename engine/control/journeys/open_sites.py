"""Sites that are open: a building's lifts and doors are connected while robots travel there, or somebody looks."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from engine.control.journeys.kept import KeptJourneys
from engine.control.journeys.site import JourneySite
from engine.processes.background import cancel_all
from engine.specs.containers import MapVersion
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.clock import Clock, monotonic
from ppaas.errors import NotFound
from storage.buildings.records import BuildingRecord
from storage.ports import MapStore
from storage.versions import ZONES

logger = logging.getLogger(__name__)

LINGER = 60.0
"""Time for which a site stays open after its last journey, and after somebody has looked at it [s]."""

FRESH = 10.0
"""Age up to which the zones of an open site count as current for those who look at it [s]."""

MOST_IDLE = 50
"""Largest number of open sites without journeys; of more, the one that was used longest ago is closed."""

TICK = 1.0
"""Time between two looks at which sites are idle [s]."""

Key = tuple[str, str]
"""Owner and id of a building."""

Make = Callable[[BuildingRecord, BuildingLayout, KeptJourneys], JourneySite]


@dataclass(slots=True)
class _OpenSite:
    """Site, its task, the versions of building and maps that it was opened with, and when it was used and checked."""

    site: JourneySite
    running: asyncio.Task[None]
    version: tuple[object, ...]
    used: float
    checked: float


class OpenSites:
    """Opens sites, and closes those that nobody needs.

    Parameters
    ----------
    map_store : MapStore
        Has the zones of floors.
    kept : callable
        Returns what is stored of the journeys of a building; may block.
    make : callable
        Makes a site of a building, its layout and what is stored of its journeys.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(
        self, map_store: MapStore, kept: Callable[[Key], KeptJourneys], make: Make, clock: Clock = monotonic
    ) -> None:
        self._map_store, self._kept, self._make, self._clock = map_store, kept, make, clock
        self._open: dict[Key, _OpenSite] = {}
        self._opening = asyncio.Lock()

    def __iter__(self) -> Iterator[JourneySite]:
        """Iterate over the open sites."""
        return iter([known.site for known in self._open.values()])

    def get(self, key: Key) -> JourneySite | None:
        """Return the site of a building if it is open."""
        known = self._open.get(key)
        return None if known is None else known.site

    async def run(self) -> None:
        """Close what nobody needs until cancelled, and then everything."""
        try:
            while True:
                await self.close_idle()
                await asyncio.sleep(TICK)
        finally:
            await self.close()

    async def close(self) -> None:
        """Close all sites."""
        await cancel_all([known.running for known in self._open.values()])
        self._open.clear()

    async def close_idle(self) -> None:
        """Close the sites without journeys that nobody has used for a while, or that are too many."""
        async with self._opening:
            now, idle = self._clock(), list[tuple[float, Key]]()
            for key, known in self._open.items():
                if known.site.is_idle:
                    idle.append((known.used, key))
                else:
                    known.used = now
            idle.sort()
            for number, (used, key) in enumerate(idle):
                if now - used > LINGER or number < len(idle) - MOST_IDLE:
                    logger.info("building %s is idle: its lifts and doors are let go", key[1])
                    await self._close(key)

    async def look(self, record: BuildingRecord) -> JourneySite:
        """Return the site of a building for somebody who looks; it stays open for a while."""
        known = self._open.get(record.key)
        if known is None or self._clock() - known.checked > FRESH or known.version[0] != record.present.number:
            return await self.site(record)
        known.used = self._clock()
        return known.site

    async def site(self, record: BuildingRecord) -> JourneySite:
        """Return the site of a building, where stored journeys go on.

        One where nobody travels is opened again if building or maps were changed.
        """
        async with self._opening:
            version = record.present.number, *(await asyncio.to_thread(self.heads, record)).values()
            known, now = self._open.get(record.key), self._clock()
            if known is not None and (known.version == version or not known.site.is_idle):
                known.used = known.checked = now
                return known.site
            layout = await asyncio.to_thread(self._layout, record)
            await self._close(record.key)
            site = self._make(record, layout, await asyncio.to_thread(self._kept, record.key))
            running = asyncio.create_task(site.run())
            self._open[record.key] = _OpenSite(site, running, version, self._clock(), self._clock())
            return site

    async def _close(self, key: Key) -> None:
        known = self._open.pop(key, None)
        if known is not None:
            known.running.cancel()
            await asyncio.gather(known.running, return_exceptions=True)

    def heads(self, record: BuildingRecord) -> dict[str, MapVersion]:
        """Return the current versions of the maps of floors; may block."""
        found = {}
        for floor in record.building.floors:
            with contextlib.suppress(NotFound):
                head = self._map_store.map_head(floor.map)
                found[floor.name] = MapVersion(head.id, head.version)
        return found

    def _layout(self, record: BuildingRecord) -> BuildingLayout:
        zones = {}
        for floor in record.building.floors:
            with (
                contextlib.suppress(NotFound),
                self._map_store.open_map(floor.map, only=(ZONES,)) as opened,
            ):
                zones[floor.name] = opened.zones()
        return layout_of(record.building, zones)
